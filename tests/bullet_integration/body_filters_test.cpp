// Filters of a body's nodes, neighbours and shape at rest, in every kind of world.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "any_simulation.hpp"

namespace softcd::test {
namespace {

/// The numbers of nodes that are in contact with faces of soft bodies.
std::multiset<int> touching_nodes(const btSoftBody& body) {
  std::multiset<int> nodes;
  const auto add = [&](const btSoftBody::Node* node) { nodes.insert(int(node - &body.m_nodes[0])); };
  for (int i = 0; i < body.m_scontacts.size(); ++i) add(body.m_scontacts[i].m_node);
  for (int i = 0; i < body.m_faceNodeContacts.size(); ++i) add(body.m_faceNodeContacts[i].m_node);
  return nodes;
}

class BodyFilter : public testing::TestWithParam<World> {
 protected:
  static bullet::Settings settings_for_tests(Detection detection = Detection::dcd) {
    bullet::Settings settings = test_settings(detection);
    settings.on_error = bullet::OnError::throw_error;
    return settings;
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, BodyFilter, kWorldsOfRun, world_name);

/// Two sheets within each other's margins.
struct NearSheets {
  AnySimulation simulation;
  btSoftBody* lower;
  btSoftBody* upper;

  NearSheets(World world, const bullet::Settings& settings) : simulation(world, settings) {
    simulation.world_info().m_gravity.setZero();
    simulation.world().setGravity(btVector3(0, 0, 0));
    SheetOptions options;
    options.margin = btScalar(0.02);
    lower = &simulation.add(make_sheet(simulation.world_info(), options));
    options.height = btScalar(0.03);
    upper = &simulation.add(make_sheet(simulation.world_info(), options));
    for (btSoftBody* body : {lower, upper}) body->m_cfg.piterations = 0;
  }

  void set_filters(const bullet::BodyFilters& filters) { simulation.detection().set_filters(*upper, filters); }
  /// Keeps all nodes of the upper sheet from everything.
  void mask_all() {
    bullet::BodyFilters filters;
    filters.nodes.assign(std::size_t(upper->m_nodes.size()), {1, 0});
    set_filters(filters);
  }
  std::size_t count_contacts() const { return touching_nodes(*lower).size() + touching_nodes(*upper).size(); }
};

TEST_P(BodyFilter, nodes_are_kept_from_the_others) {
  NearSheets sheets(GetParam(), settings_for_tests());
  NearSheets all(GetParam(), settings_for_tests());
  // A third of the nodes, of two of the groups that the faces below have.
  bullet::BodyFilters filters;
  filters.nodes.resize(std::size_t(sheets.upper->m_nodes.size()));
  for (std::size_t i = 0; i < filters.nodes.size(); i += 3) filters.nodes[i].mask = 2;
  sheets.set_filters(filters);
  sheets.simulation.step();
  all.simulation.step();
  std::multiset<int> expected = touching_nodes(*all.upper);
  ASSERT_GT(expected.size(), 20U);
  for (int i = 0; i < sheets.upper->m_nodes.size(); i += 3) expected.erase(i);
  EXPECT_EQ(touching_nodes(*sheets.upper), expected);
  EXPECT_FALSE(touching_nodes(*sheets.lower).empty());
}

TEST_P(BodyFilter, nodes_are_kept_from_everything_until_told_otherwise) {
  NearSheets sheets(GetParam(), settings_for_tests());
  bullet::BodyFilters filters;
  filters.nodes.assign(std::size_t(sheets.upper->m_nodes.size()), {1, 0});
  sheets.set_filters(filters);
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
  sheets.set_filters({});
  sheets.simulation.step();
  EXPECT_GT(sheets.count_contacts(), 0U);
  filters.nodes[0] = {};
  sheets.set_filters(filters);
  sheets.simulation.step();
  EXPECT_GT(sheets.count_contacts(), 0U);
  EXPECT_LT(sheets.count_contacts(), 20U);
}

/// A sheet of few nodes whose margin is larger than its edges.
struct CoarseSheet {
  AnySimulation simulation;
  btSoftBody* body;

  CoarseSheet(World world, const bullet::Settings& settings) : simulation(world, settings) {
    simulation.world_info().m_gravity.setZero();
    simulation.world().setGravity(btVector3(0, 0, 0));
    SheetOptions options;
    options.nodes_per_side = 7;
    options.margin = btScalar(0.1);
    body = &simulation.add(make_sheet(simulation.world_info(), options));
    body->setSelfCollision(true);
    body->m_cfg.piterations = 0;
  }

  void set_filters(const bullet::BodyFilters& filters) { simulation.detection().set_filters(*body, filters); }
  std::uint64_t step() {
    simulation.step();
    return simulation.detection().contact_report().statistics().vt_contacts;
  }
};

TEST_P(BodyFilter, neighbours_are_kept_from_each_other) {
  CoarseSheet sheet(GetParam(), settings_for_tests());
  EXPECT_GT(sheet.step(), 50U);
  bullet::BodyFilters filters;
  filters.neighbour_rings = 3;
  sheet.set_filters(filters);
  EXPECT_EQ(sheet.step(), 0U);
  sheet.set_filters({});
  EXPECT_GT(sheet.step(), 50U);
}

TEST_P(BodyFilter, what_is_near_at_rest_is_kept_from_each_other) {
  CoarseSheet sheet(GetParam(), settings_for_tests());
  bullet::BodyFilters filters;
  // The deformable world's rule reaches further than the margins.
  filters.rest_distance = is_deformable(GetParam()) ? 0.46F : 0.21F;
  sheet.set_filters(filters);
  EXPECT_EQ(sheet.step(), 0U);
  // Nodes that were far from each other are near when the sheet is rolled up.
  for (int i = 0; i < sheet.body->m_nodes.size(); ++i) {
    btSoftBody::Node& node = sheet.body->m_nodes[i];
    const btScalar angle = node.m_x.x() * btScalar(6);
    node.m_x = node.m_q = btVector3(btScalar(0.14) * btCos(angle), btScalar(0.14) * btSin(angle), node.m_x.z());
    node.m_v.setZero();
  }
  EXPECT_GT(sheet.step(), 5U);
}

TEST_P(BodyFilter, neighbours_do_not_pass_through_each_other) {
  if (GetParam() == World::dispatcher) GTEST_SKIP() << "does not look at crossings";
  for (const std::uint32_t rings : {1U, 16U}) {
    CoarseSheet sheet(GetParam(), settings_for_tests(Detection::ccd));
    bullet::BodyFilters filters;
    filters.neighbour_rings = rings;
    sheet.set_filters(filters);
    // A corner, folded over a face near it, goes down through that.
    btSoftBody::Node& corner = sheet.body->m_nodes[0];
    corner.m_x = corner.m_q =
        (sheet.body->m_nodes[8].m_x + sheet.body->m_nodes[9].m_x + sheet.body->m_nodes[16].m_x) / 3 +
        btVector3(0, btScalar(0.02), 0);
    corner.m_v = btVector3(0, -20, 0);
    std::uint64_t impacts = 0;
    sheet.simulation.step([&](btScalar) { impacts += sheet.simulation.detection().crossing_answers().impacts; });
    impacts += sheet.simulation.detection().crossing_answers().impacts;
    EXPECT_GT(corner.m_x.y(), btScalar(-0.1)) << rings << " rings";
    if (rings == 16) {
      EXPECT_EQ(sheet.simulation.detection().contact_report().statistics().vt_contacts, 0U);
      EXPECT_GT(impacts, 0U);
    }
  }
}

TEST_P(BodyFilter, what_is_kept_from_touching_passes_through) {
  if (GetParam() == World::dispatcher) GTEST_SKIP() << "does not look at crossings";
  for (const bool is_masked : {false, true}) {
    NearSheets sheets(GetParam(), settings_for_tests(Detection::ccd));
    if (is_masked) sheets.mask_all();
    sheets.upper->setVelocity(btVector3(0, -30, 0));
    sheets.simulation.step();
    EXPECT_EQ(mean_height(*sheets.upper) < mean_height(*sheets.lower), is_masked);
  }
}

TEST_P(BodyFilter, are_forgotten_with_the_body) {
  NearSheets sheets(GetParam(), settings_for_tests());
  sheets.mask_all();
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
  std::unique_ptr<btSoftBody> upper = sheets.simulation.remove(*sheets.upper);
  sheets.simulation.step();
  sheets.upper = &sheets.simulation.add(std::move(upper));
  sheets.simulation.step();
  EXPECT_GT(sheets.count_contacts(), 0U);
}

TEST_P(BodyFilter, are_forgotten_with_the_nodes_that_they_are_of) {
  std::vector<std::string> warnings;
  bullet::Settings settings = settings_for_tests();
  settings.log = [&](LogLevel level, std::string_view text) {
    if (level == LogLevel::warning) warnings.emplace_back(text);
  };
  NearSheets sheets(GetParam(), settings);
  sheets.mask_all();
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
  sheets.upper->appendNode(sheets.upper->m_nodes[0].m_x, 1);
  sheets.simulation.step();
  EXPECT_GT(sheets.count_contacts(), 0U);
  EXPECT_EQ(std::count(
                warnings.begin(), warnings.end(),
                "the filters of a soft body were removed, because its number of nodes has changed since they were set"),
            1);
}

TEST_P(BodyFilter, that_are_out_of_range_are_errors) {
  NearSheets sheets(GetParam(), settings_for_tests());
  const auto error = [&](const bullet::BodyFilters& filters) -> std::string {
    try {
      sheets.set_filters(filters);
    } catch (const InvalidInput& problem) {
      return problem.what();
    }
    return "no error";
  };
  bullet::BodyFilters filters;
  filters.nodes.resize(3);
  EXPECT_EQ(error(filters), "softcd::bullet::BodyFilters: there are 3 filters of nodes, but the body has 81 nodes");
  filters.nodes.clear();
  filters.neighbour_rings = 17;
  EXPECT_EQ(error(filters), "softcd::bullet::BodyFilters: neighbour_rings is 17, but must be 1 to 16");
  filters.neighbour_rings = 2;
  filters.rest_distance = -1;
  EXPECT_EQ(error(filters).substr(0, 48), "softcd::bullet::BodyFilters: rest_distance is -1");
  filters.rest_distance = 0.1F;
  EXPECT_EQ(error(filters), "no error");
  sheets.upper->m_nodes[4].m_x.setY(SIMD_INFINITY);
  sheets.upper->m_nodes[4].m_x.setZ(std::numeric_limits<btScalar>::quiet_NaN());
  EXPECT_EQ(error(filters).substr(0, 34), "softcd::bullet::BodyFilters: node ");
}

TEST_P(BodyFilter, stay_when_faces_are_others) {
  NearSheets sheets(GetParam(), settings_for_tests());
  bullet::BodyFilters filters;
  filters.nodes.assign(std::size_t(sheets.upper->m_nodes.size()), {1, 0});
  sheets.simulation.detection().set_filters(*sheets.upper, filters);
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
  btSoftBody::Face& face = sheets.upper->m_faces[0];
  std::rotate(std::begin(face.m_n), std::begin(face.m_n) + 1, std::end(face.m_n));
  sheets.simulation.step();
  EXPECT_EQ(sheets.count_contacts(), 0U);
}

}  // namespace
}  // namespace softcd::test
