// Settings::contacts and contacts_per_node choose contacts for Bullet's solver among those of Bullet's rule.

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "any_simulation.hpp"
#include "exact_contacts.hpp"
#include "random.hpp"
#include "reference_distance.hpp"
#include "scenes/soft_ball.hpp"
#include "soft_body_support.hpp"
#include "softcd/bullet/soft_worlds.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::test {
namespace {

using bullet::Contacts;
using demo::PlugIn;
using demo::Simulation;
using SContact = btSoftBody::SContact;

constexpr btScalar kThickness = btScalar(0.05);
constexpr btScalar kCell = btScalar(0.125);
constexpr int kNodes = 9;  // a side of a sheet
constexpr long double kRounding = 2e-6L;

bullet::Settings settings_with(Contacts contacts, std::uint32_t per_node = 0) {
  bullet::Settings settings = test_settings();
  settings.contacts = contacts;
  settings.contacts_per_node = per_node;
  return settings;
}

/// Bodies that stay where they are put: nothing pulls at them, and Bullet does not solve their contacts.
class Still {
 public:
  explicit Still(const bullet::Settings& settings, PlugIn plug_in = PlugIn::one_line_world)
      : simulation_(plug_in, settings) {
    simulation_.world_info().m_gravity.setZero();
  }

  btSoftBody& add(const demo::ClothShape& shape) {
    auto sheet = demo::make_cloth(simulation_.world_info(), shape, 1);
    sheet->getCollisionShape()->setMargin(kThickness);
    sheet->m_cfg.piterations = 0;
    sheet->m_cfg.kDF = btScalar(0.25);
    bodies_.push_back(&simulation_.add(std::move(sheet)));
    return *bodies_.back();
  }
  void step() { simulation_.step(kStep); }

  Simulation& simulation() { return simulation_; }
  const std::vector<btSoftBody*>& bodies() const { return bodies_; }

 private:
  Simulation simulation_;
  std::vector<btSoftBody*> bodies_;
};

demo::ClothShape flat(btScalar height, btScalar shift = 0) {
  demo::ClothShape shape;
  shape.columns = shape.rows = kNodes;
  shape.position = [=](int column, int row) {
    return btVector3(kCell * btScalar(column) + shift, height, kCell * btScalar(row) + shift);
  };
  return shape;
}

/// Each node off its place by up to `most` along every axis.
demo::ClothShape bumpy(btScalar height, btScalar most, Random& random) {
  demo::ClothShape shape = flat(height);
  btAlignedObjectArray<btVector3> offsets;
  for (int i = 0; i < kNodes * kNodes; ++i) {
    const auto offset = [&] { return btScalar(random.uniform(double(-most), double(most))); };
    offsets.push_back(btVector3{offset(), offset(), offset()});
  }
  shape.position = [=, on = shape.position](int column, int row) {
    return on(column, row) + offsets[row * kNodes + column];
  };
  return shape;
}

/// Two layers of one body at heights 0 and `gap`, joined along x = 0.
demo::ClothShape folded(btScalar gap) {
  demo::ClothShape shape;
  shape.columns = 2 * kNodes;
  shape.rows = kNodes;
  shape.position = [=](int column, int row) {
    const bool is_lower = column < kNodes;
    const int from_bend = is_lower ? kNodes - 1 - column : column - kNodes;
    return btVector3(kCell * btScalar(from_bend), is_lower ? 0 : gap, kCell * btScalar(row));
  };
  return shape;
}

/// Contacts of one node with one body: the body of a face is that whose array has it.
struct Site {
  const btSoftBody::Node* node;
  const btSoftBody* body;

  friend bool operator<(const Site& a, const Site& b) { return std::tie(a.node, a.body) < std::tie(b.node, b.body); }
};
using Sites = std::map<Site, std::vector<SContact>>;

const btSoftBody* body_of(const btSoftBody::Face& face, const std::vector<btSoftBody*>& bodies) {
  for (const btSoftBody* body : bodies) {
    if (&face >= &body->m_faces[0] && &face < &body->m_faces[0] + body->m_faces.size()) return body;
  }
  ADD_FAILURE() << "a contact names a face of no body";
  return nullptr;
}

Sites sites_of(const std::vector<btSoftBody*>& bodies) {
  Sites sites;
  for (const btSoftBody* owner : bodies) {
    for (int i = 0; i < owner->m_scontacts.size(); ++i) {
      const SContact& contact = owner->m_scontacts[i];
      sites[{contact.m_node, body_of(*contact.m_face, bodies)}].push_back(contact);
    }
  }
  return sites;
}

using Feature = std::set<const btSoftBody::Node*>;

/// The nodes of the smallest feature with the contact's point.
Feature feature_of(const SContact& contact) {
  Feature feature;
  for (int i = 0; i < 3; ++i) {
    if (contact.m_weights[i] > 0) feature.insert(contact.m_face->m_n[i]);
  }
  return feature;
}

bool has(const btSoftBody::Face& face, const Feature& feature) {
  return std::all_of(feature.begin(), feature.end(), [&](const btSoftBody::Node* node) {
    return node == face.m_n[0] || node == face.m_n[1] || node == face.m_n[2];
  });
}

/// Features at which the distance from the node has a minimum: no face at them is nearer by more than `slack`.
std::set<Feature> minima_of(const std::vector<SContact>& all, long double slack) {
  std::set<Feature> minima;
  for (const SContact& contact : all) {
    const Feature feature = feature_of(contact);
    const bool is_minimum = std::none_of(all.begin(), all.end(), [&](const SContact& other) {
      return has(*other.m_face, feature) && distance_of(other) < distance_of(contact) - slack;
    });
    if (is_minimum) minima.insert(feature);
  }
  return minima;
}

bool is_part_of(const Feature& a, const Feature& b) {
  return std::includes(b.begin(), b.end(), a.begin(), a.end());
}

/// One contact for each minimum, and no other but what pushes away from its nearer ones. Where a node is so nearly over
/// an edge or a corner that float cannot tell the distances apart, the feature may be the edge, the corner or a face
/// there.
void expect_minima(const std::vector<SContact>& all, const std::map<Feature, SContact>& chosen) {
  const std::set<Feature> possible = minima_of(all, kRounding);
  for (const auto& [feature, contact] : chosen) {
    const bool faces_another = std::any_of(chosen.begin(), chosen.end(), [&, &mine = contact](const auto& other) {
      return other.second.m_normal.dot(mine.m_normal) <= 0 && distance_of(other.second) <= distance_of(mine);
    });
    EXPECT_TRUE(possible.count(feature) > 0 || faces_another);
  }
  for (const Feature& minimum : minima_of(all, 1e-13L)) {
    EXPECT_TRUE(std::any_of(chosen.begin(), chosen.end(), [&](const auto& choice) {
      return is_part_of(choice.first, minimum) || is_part_of(minimum, choice.first);
    }));
  }
}

/// Judges what two worlds in the same state were given.
struct Given {
  Still all, chosen;
  Sites all_sites, chosen_sites;

  template <class Build>
  Given(const bullet::Settings& settings, Build build) : all(settings_with(Contacts::all)), chosen(settings) {
    for (Still* still : {&all, &chosen}) {
      build(*still);
      still->step();
    }
    all_sites = sites_of(all.bodies());
    chosen_sites = sites_of(chosen.bodies());
  }

  /// The same nodes in the world with all contacts.
  Feature in_all(const Feature& feature) const {
    Feature twins;
    for (std::size_t b = 0; b < all.bodies().size(); ++b) {
      btSoftBody::tNodeArray& nodes = chosen.bodies()[b]->m_nodes;
      for (const btSoftBody::Node* node : feature) {
        if (node < &nodes[0] || node >= &nodes[0] + nodes.size()) continue;
        twins.insert(&all.bodies()[b]->m_nodes[static_cast<int>(node - &nodes[0])]);
      }
    }
    return twins;
  }

  /// Returns the chosen contacts at a site of the world with all contacts.
  std::vector<SContact> chosen_at(const Site& site) const {
    for (std::size_t b = 0; b < all.bodies().size(); ++b) {
      const btSoftBody& owner = *all.bodies()[b];
      if (site.node < &owner.m_nodes[0] || site.node >= &owner.m_nodes[0] + owner.m_nodes.size()) continue;
      const auto body = std::find(all.bodies().begin(), all.bodies().end(), site.body) - all.bodies().begin();
      const Site twin{&chosen.bodies()[b]->m_nodes[static_cast<int>(site.node - &owner.m_nodes[0])],
                      chosen.bodies()[static_cast<std::size_t>(body)]};
      const auto found = chosen_sites.find(twin);
      return found == chosen_sites.end() ? std::vector<SContact>() : found->second;
    }
    return {};
  }
};

long double nearest_of(const std::vector<SContact>& contacts) {
  long double nearest = 1e9L;
  for (const SContact& contact : contacts) nearest = std::min(nearest, distance_of(contact));
  return nearest;
}

std::vector<const char*> build_names() {
  return {"bumps on bumps", "bumps on a plane", "nodes over corners", "nodes over edges", "between layers"};
}

/// Bodies to be judged, in states of which each is another one for another seed where there is chance in it.
void build(Still& still, const std::string& name, std::uint64_t seed) {
  Random random(seed);
  if (name == "bumps on bumps" || name == "bumps on a plane") {
    still.add(name == "bumps on bumps" ? bumpy(0, btScalar(0.04), random) : flat(0));
    still.add(bumpy(btScalar(0.06), btScalar(0.04), random));
  } else if (name == "between layers") {
    still.add(folded(btScalar(0.12)));
    still.add(bumpy(btScalar(0.06), btScalar(0.03), random));
  } else {
    still.add(flat(0));
    still.add(flat(btScalar(0.0625), name == "nodes over edges" ? kCell / 2 : 0));
  }
}

TEST(ContactEconomy, gives_one_contact_for_each_place_that_is_nearest) {
  std::size_t chosen_count = 0, all_count = 0;
  for (const std::string name : build_names()) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      const Given given(settings_with(Contacts::closest_feature), [&](Still& still) { build(still, name, seed); });
      ASSERT_FALSE(given.all_sites.empty());
      for (const auto& [site, contacts] : given.all_sites) {
        const std::vector<SContact> chosen = given.chosen_at(site);
        EXPECT_NEAR(double(nearest_of(chosen)), double(nearest_of(contacts)), double(kRounding));
        std::map<Feature, SContact> features;
        for (const SContact& contact : chosen) features.emplace(given.in_all(feature_of(contact)), contact);
        EXPECT_EQ(features.size(), chosen.size()) << "a feature has two contacts";
        expect_minima(contacts, features);
        chosen_count += chosen.size();
        all_count += contacts.size();
      }
    }
  }
  EXPECT_LT(chosen_count, all_count / 2) << "the scenes have little to choose from";
}

TEST(ContactEconomy, a_contact_answers_for_those_that_it_stands_for) {
  const auto corners = [](Still& still) { build(still, "nodes over corners", 1); };
  const Given given(settings_with(Contacts::closest_feature), corners);
  for (const auto& [site, contacts] : given.all_sites) {
    const std::vector<SContact> chosen = given.chosen_at(site);
    ASSERT_EQ(chosen.size(), 1U);
    const SContact& first = contacts.front();
    EXPECT_EQ(chosen[0].m_normal, first.m_normal);
    EXPECT_EQ(chosen[0].m_weights, first.m_weights);
    EXPECT_EQ(chosen[0].m_margin, first.m_margin);
    EXPECT_EQ(chosen[0].m_cfm[0], first.m_cfm[0]);
    EXPECT_EQ(chosen[0].m_cfm[1], first.m_cfm[1]);
    const double left = std::pow(1 - double(first.m_friction), double(contacts.size()));
    EXPECT_NEAR(double(chosen[0].m_friction), 1 - left, 1e-6);
  }
}

TEST(ContactEconomy, a_node_between_layers_of_one_body_is_held_by_both) {
  for (const std::uint32_t per_node : {0U, 1U}) {
    for (const Contacts rule : {Contacts::all, Contacts::closest_feature}) {
      if (rule == Contacts::all && per_node == 0) continue;
      Still still(settings_with(rule, per_node));
      still.add(folded(btScalar(0.12)));
      btSoftBody& between = still.add(flat(btScalar(0.0625), kCell / 4));
      still.step();
      const Sites sites = sites_of(still.bodies());
      for (int row = 0; row < kNodes - 1; ++row) {
        for (int column = 1; column < kNodes - 1; ++column) {  // the first is at the bend, too
          const auto site = sites.find({&between.m_nodes[row * kNodes + column], still.bodies()[0]});
          ASSERT_NE(site, sites.end());
          ASSERT_EQ(site->second.size(), 2U) << per_node;
          EXPECT_LT(site->second[0].m_normal.dot(site->second[1].m_normal), btScalar(-0.99));
        }
      }
    }
  }
}

TEST(ContactEconomy, a_bound_leaves_the_nearest_on_each_side) {
  std::size_t dropped = 0;
  for (const std::uint32_t most : {1U, 2U, 3U}) {
    for (const std::string name : build_names()) {
      const Given given(settings_with(Contacts::all, most), [&](Still& still) { build(still, name, 7); });
      for (const auto& [site, contacts] : given.all_sites) {
        const std::vector<SContact> chosen = given.chosen_at(site);
        ASSERT_FALSE(chosen.empty()) << name;
        EXPECT_NEAR(double(nearest_of(chosen)), double(nearest_of(contacts)), double(kRounding));
        for (const SContact& contact : contacts) {
          const auto count = std::count_if(chosen.begin(), chosen.end(), [&](const SContact& other) {
            return other.m_normal.dot(contact.m_normal) > 0 && distance_of(other) <= distance_of(contact) + kRounding;
          });
          const bool is_given = std::any_of(chosen.begin(), chosen.end(), [&](const SContact& other) {
            return other.m_normal == contact.m_normal && other.m_weights == contact.m_weights;
          });
          EXPECT_TRUE(is_given || count >= static_cast<std::ptrdiff_t>(most)) << name << ", " << most;
        }
        dropped += contacts.size() - chosen.size();
      }
    }
  }
  EXPECT_GT(dropped, 0U);
}

/// Returns the normals' heights of the contacts of a sheet with a sheet at rest. The sheet begins the step at this
/// height, and moves like this in the step. Nodes beside the sheet at rest, whose normals are slanted, do not count.
std::vector<btScalar> normals_of_moving_sheet(Contacts contacts, btScalar height, const btVector3& motion,
                                              btScalar shift = 0) {
  Still still(settings_with(contacts));
  still.add(flat(0));
  btSoftBody& moving = still.add(flat(height, shift));
  moving.setVelocity(motion / kStep);
  moving.m_cfg.kDP = 0;
  still.step();
  std::vector<btScalar> heights;
  for (int i = 0; i < moving.m_scontacts.size(); ++i) {
    const btScalar along_y = moving.m_scontacts[i].m_normal.y();
    if (btFabs(along_y) > btScalar(0.99)) heights.push_back(along_y);
  }
  return heights;
}

TEST(ContactEconomy, what_moves_sideways_or_away_beyond_the_margins_gets_no_contact) {
  const btVector3 motions[] = {{btScalar(0.05), 0, 0}, {0, btScalar(0.05), 0}, {0, btScalar(-0.05), 0}};
  for (const btVector3& motion : motions) {
    for (const Contacts contacts : {Contacts::all, Contacts::closest_feature}) {
      const auto given = normals_of_moving_sheet(contacts, btScalar(0.13) - motion.y(), motion).size();
      if (motion.y() < 0) {
        EXPECT_GE(given, static_cast<std::size_t>((kNodes - 1) * (kNodes - 1))) << "it comes closer";
      } else {
        EXPECT_EQ(given, 0U) << "it moves sideways or away";
      }
    }
  }
}

TEST(ContactEconomy, pushes_nodes_back_that_have_passed_through_another_body) {
  const auto is_up = [](btScalar height) { return height > 0; };
  const auto is_down = [](btScalar height) { return height < 0; };
  for (const btScalar shift : {btScalar(0), kCell / 4, kCell / 2}) {  // over corners, in faces, over diagonals
    const auto all_are = [&](auto predicate, Contacts contacts, btScalar from, btScalar to) {
      const auto heights = normals_of_moving_sheet(contacts, from, btVector3(0, to - from, 0), shift);
      return heights.size() >= (kNodes - 1) * (kNodes - 1) && std::all_of(heights.begin(), heights.end(), predicate);
    };
    const btScalar height = btScalar(0.03);
    EXPECT_TRUE(all_are(is_up, Contacts::closest_feature, height, -height)) << shift << ", through, downwards";
    EXPECT_TRUE(all_are(is_down, Contacts::closest_feature, -height, height)) << shift << ", through, upwards";
    EXPECT_TRUE(all_are(is_up, Contacts::closest_feature, height, height / 2)) << shift << ", above";
    EXPECT_TRUE(all_are(is_down, Contacts::closest_feature, -height, -height / 2)) << shift << ", below";
    EXPECT_TRUE(all_are(is_down, Contacts::all, height, -height)) << shift << ", Bullet's own rule";
  }
}

/// A sheet that is bent down on both sides of the line x = 4 * kCell.
demo::ClothShape bent_sheet() {
  demo::ClothShape shape = flat(0);
  shape.position = [on = shape.position](int column, int row) {
    btVector3 x = on(column, row);
    x.setY(-btFabs(x.x() - kCell * btScalar(4)));
    return x;
  };
  return shape;
}

// Nodes that pass through one slope close to the ridge end above the ridge, as near to one slope as to the other.
TEST(ContactEconomy, pushes_nodes_back_that_end_near_another_face_than_they_have_passed_through) {
  for (const btScalar beside : {btScalar(-0.002), btScalar(0.002)}) {
    Still still(settings_with(Contacts::closest_feature));
    still.add(bent_sheet());
    demo::ClothShape line = flat(btScalar(-0.03));
    line.position = [=, on = line.position](int column, int row) {
      return on(column, row) + btVector3(beside, 0, kCell / 4);
    };
    btSoftBody& moving = still.add(line);
    moving.setVelocity(btVector3(0, btScalar(0.06), 0) / kStep);
    moving.m_cfg.kDP = 0;
    still.step();
    int pushed_down = 0;
    for (int i = 0; i < moving.m_scontacts.size(); ++i) {
      const SContact& contact = moving.m_scontacts[i];
      const auto node = contact.m_node - &moving.m_nodes[0];
      if (node % kNodes != 4 || node / kNodes == kNodes - 1) continue;  // not over the ridge
      EXPECT_LT(contact.m_normal.y(), 0) << "beside the ridge by " << beside;
      ++pushed_down;
    }
    EXPECT_GE(pushed_down, kNodes - 1);
  }
}

TEST(ContactEconomy, pushes_nodes_out_of_closed_bodies_whichever_way_they_go) {
  for (const btScalar from : {btScalar(1.9), btScalar(2.1)}) {
    Still still(settings_with(Contacts::closest_feature));
    auto ball = demo::make_soft_ball(still.simulation().world_info(), demo::World::classic,
                                     {{0, 0, 0}, /*radius=*/2, /*subdivisions=*/3, /*mass=*/1, kThickness});
    ball->m_cfg.piterations = 0;
    still.simulation().add(std::move(ball));
    demo::ClothShape patch;
    patch.columns = patch.rows = 3;
    patch.position = [=](int column, int row) {
      return btVector3(btScalar(0.05) + btScalar(0.02) * btScalar(column), from, btScalar(0.02) * btScalar(row));
    };
    btSoftBody& moving = still.add(patch);
    moving.setVelocity(btVector3(0, 2 * (2 - from), 0) / kStep);
    moving.m_cfg.kDP = 0;
    still.step();
    EXPECT_GE(moving.m_scontacts.size(), 9) << "from " << from;
    for (int i = 0; i < moving.m_scontacts.size(); ++i) {
      EXPECT_GT(moving.m_scontacts[i].m_normal.y(), btScalar(0.5)) << "from " << from;
    }
  }
}

TEST(ContactEconomy, depends_neither_on_threads_nor_on_the_way_in) {
  const auto contacts_with = [](std::size_t threads, PlugIn plug_in) {
    const parallel::ThreadLimit limit(threads);
    Still still(settings_with(Contacts::closest_feature), plug_in);
    Random random(3);
    for (int i = 0; i < 12; ++i) still.add(bumpy(btScalar(0.03) * btScalar(i), btScalar(0.04), random));
    still.step();
    std::vector<std::tuple<int, long, long, btScalar, btScalar, btScalar>> contacts;
    for (const btSoftBody* body : still.bodies()) {
      for (int i = 0; i < body->m_scontacts.size(); ++i) {
        const SContact& contact = body->m_scontacts[i];
        const btSoftBody& other = *body_of(*contact.m_face, still.bodies());
        contacts.emplace_back(i, contact.m_node - &body->m_nodes[0], contact.m_face - &other.m_faces[0],
                              contact.m_weights.x(), contact.m_normal.y(), contact.m_friction);
      }
    }
    return contacts;
  };
  const auto one = contacts_with(1, PlugIn::one_line_world);
  EXPECT_GT(one.size(), 2000U) << "too few to be shared by threads";
  EXPECT_EQ(contacts_with(2, PlugIn::one_line_world), one);
  EXPECT_EQ(contacts_with(7, PlugIn::dispatcher), one);
  EXPECT_EQ(contacts_with(3, PlugIn::multi_body_world), one);
}

TEST(ContactEconomy, is_explained) {
  const auto last_line = [](Still& still) { return still.simulation().detection()->contact_report().explain().back(); };
  Still all(settings_with(Contacts::all));
  build(all, "nodes over corners", 1);
  all.step();
  EXPECT_EQ(last_line(all).stage, "contact economy");
  EXPECT_FALSE(last_line(all).ran);
  EXPECT_EQ(bullet::Settings().contacts, Contacts::automatic);
  Still chosen(settings_with(Contacts::closest_feature));
  build(chosen, "nodes over corners", 1);
  chosen.step();
  EXPECT_TRUE(last_line(chosen).ran);
  EXPECT_NE(last_line(chosen).reason.find(" 162 of "), std::string::npos) << last_line(chosen).reason;
}

/// Mean gap, and contacts, of a sheet that has come to rest on a fixed one after a second.
std::pair<btScalar, std::size_t> rest(World world, Contacts given, btScalar height = btScalar(0.08)) {
  AnySimulation simulation(world, settings_with(given));
  SheetOptions fixed;
  fixed.fixed = true;
  fixed.margin = btScalar(0.03);
  simulation.add(make_sheet(simulation.world_info(), fixed));
  SheetOptions free = fixed;
  free.fixed = false;
  free.side = btScalar(0.9);
  free.height = height;
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), free));
  btScalar sum = 0;
  std::size_t contacts = 0;
  const int steps = static_cast<int>(1 / simulation.step_length());
  const int steps_to_rest = steps * 3 / 4;
  for (int i = 0; i < steps; ++i) {
    simulation.step_once();
    if (i >= steps_to_rest) sum += mean_height(sheet);
    contacts += static_cast<std::size_t>(sheet.m_scontacts.size() + sheet.m_faceNodeContacts.size());
  }
  return {sum / btScalar(steps - steps_to_rest), contacts};
}

void expect_same_rest(World world) {
  const auto all = rest(world, Contacts::all);
  const auto chosen = rest(world, Contacts::closest_feature);
  EXPECT_NEAR(double(chosen.first), double(all.first), 0.02 * double(all.first));
  EXPECT_LE(chosen.second, all.second / 2);
}

TEST(ContactEconomy, a_sheet_rests_as_high_in_the_classic_world) {
  expect_same_rest(World::one_line);
}

/// Bullet's classic margins let no node lie still, and where the hops of a second end depends on every bit of the
/// start.
TEST(ContactEconomy, sheets_rest_as_high_on_average_in_the_classic_world) {
  double all_sum = 0, chosen_sum = 0;
  for (int start = 0; start < 4; ++start) {
    const btScalar height = btScalar(0.08) + btScalar(start) * btScalar(0.001);
    all_sum += double(rest(World::one_line, Contacts::all, height).first);
    chosen_sum += double(rest(World::one_line, Contacts::closest_feature, height).first);
  }
  EXPECT_NEAR(chosen_sum, all_sum, 0.01 * all_sum);
}

TEST(ContactEconomy, a_sheet_rests_as_high_in_the_deformable_world) {
  expect_same_rest(World::deformable);
}

/// Two edges in contact, by their nodes.
using Edges = std::set<Feature>;

Feature edge_of(const bullet::EdgeContact::Side& side) {
  return {&side.body->m_nodes[side.nodes[0]], &side.body->m_nodes[side.nodes[1]]};
}

/// The edges in contact that Bullet's solver is given, behind `node_contacts` contacts of each body's nodes.
std::set<Edges> given_edges(const std::vector<btSoftBody*>& bodies, const std::vector<int>& node_contacts) {
  std::set<Edges> given;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const btSoftBody::tSContactArray& contacts = bodies[b]->m_scontacts;
    for (int i = node_contacts[b]; i + 1 < contacts.size(); i += 2) {
      given.insert({{contacts[i].m_node, contacts[i + 1].m_node}, feature_of(contacts[i])});
    }
  }
  return given;
}

/// The distance of an edge from the nearest of the other side's faces at its own edge.
long double distance_from_faces(const bullet::EdgeContact::Side& edge, const bullet::EdgeContact::Side& other) {
  const auto end = [&](int i) { return position_of(edge.body->m_nodes[edge.nodes[i]]); };
  long double nearest = 1e9L;
  for (int f = 0; f < other.body->m_faces.size(); ++f) {
    const btSoftBody::Face& face = other.body->m_faces[f];
    if (!has(face, edge_of(other))) continue;
    for (int i = 0; i < 3; ++i) {
      const auto corner = [&](int c) { return position_of(*face.m_n[c % 3]); };
      nearest = std::min(nearest, distance_edge_edge(end(0), end(1), corner(i), corner(i + 1)));
      if (i < 2) nearest = std::min(nearest, distance_vertex_triangle(end(i), corner(0), corner(1), corner(2)));
    }
  }
  return nearest;
}

bool is_end_nearest(const bullet::EdgeContact::Side& side) {
  return !(side.weights[0] > 0) || !(side.weights[1] > 0);
}

class EdgeEconomy : public testing::TestWithParam<Detection> {
 protected:
  static bullet::Settings settings(bullet::EdgeContacts edges) {
    bullet::Settings settings = test_settings(GetParam());
    settings.contacts = Contacts::closest_feature;
    settings.edge_contacts = edges;
    return settings;
  }
  /// Two sheets that do not intersect.
  static void build_bumps(Still& still, std::uint64_t seed) {
    Random random(seed);
    still.add(bumpy(0, btScalar(0.025), random));
    still.add(bumpy(btScalar(0.06), btScalar(0.025), random));
    still.step();
  }
};
INSTANTIATE_TEST_SUITE_P(Detections, EdgeEconomy, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& parameter) { return parameter.param == Detection::dcd ? "dcd" : "ccd"; });

TEST_P(EdgeEconomy, gives_edges_that_are_nearest_along_the_faces_at_them) {
  std::size_t given_count = 0, dropped_count = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Still without(settings(bullet::EdgeContacts::off));
    build_bumps(without, seed);
    std::vector<int> node_contacts;
    for (const btSoftBody* body : without.bodies()) node_contacts.push_back(body->m_scontacts.size());
    Still still(settings(bullet::EdgeContacts::respond));
    build_bumps(still, seed);
    const std::set<Edges> given = given_edges(still.bodies(), node_contacts);
    for (const bullet::EdgeContact& contact : still.simulation().detection()->edge_contacts()) {
      const long double nearest =
          std::min(distance_from_faces(contact.a, contact.b), distance_from_faces(contact.b, contact.a));
      const long double gain = static_cast<long double>(contact.distance) - nearest;
      if (gain > 0 && gain < kRounding) continue;
      const bool is_nearest = gain <= 0 && !is_end_nearest(contact.a) && !is_end_nearest(contact.b);
      EXPECT_EQ(given.count({edge_of(contact.a), edge_of(contact.b)}), is_nearest ? 1U : 0U) << double(gain);
      ++(is_nearest ? given_count : dropped_count);
    }
  }
  EXPECT_GT(given_count, 20U);
  EXPECT_GT(dropped_count, given_count);
}

/// With all contacts of edges a ball's flat sides held each other: each step gave Bullet's solver some hundred contacts
/// a node, and the balls stayed flat.
TEST(ContactEconomy, balls_that_fall_on_each_other_have_few_contacts_with_safe) {
  bullet::Settings settings = bullet::Settings::safe();
  settings.backend = backend_under_test();
  demo::SoftWorld world(demo::World::classic, PlugIn::one_line_world, settings);
  world.add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  constexpr int kBalls = 8;
  std::size_t nodes = 0, most = 0;
  for (int i = 0; i < kBalls; ++i) {
    const btScalar shift = btScalar(0.05) * btScalar(i % 3);
    const btVector3 center(shift, btScalar(0.4) + btScalar(0.65) * btScalar(i), btScalar(0.1) - shift);
    btSoftBody& ball = world.add(demo::make_soft_ball(world, {center, btScalar(0.3), 2, 1, btScalar(0.03)}));
    ball.m_cfg.piterations = 4;
    nodes += static_cast<std::size_t>(ball.m_nodes.size());
  }
  for (int i = 0; i < 60; ++i) {
    world.step();
    most = std::max(most, world.count_soft_contacts());
  }
  EXPECT_GT(most, 0U);
  EXPECT_LT(most, 10 * nodes);
}

// Nodes that pass through both layers of a fold in one step: each has the contact with the layer that it meets first.
TEST(ContactEconomy, a_bound_leaves_what_is_met_first) {
  bullet::Settings settings = settings_with(Contacts::all, 1);
  settings.detection = Detection::ccd;
  constexpr btScalar kGap = btScalar(0.4);
  Still still(settings);
  const btSoftBody& fold = still.add(folded(kGap));
  std::set<const btSoftBody::Node*> upper;
  for (int i = 0; i < fold.m_nodes.size(); ++i) {
    if (fold.m_nodes[i].m_x.y() > kGap / 2) upper.insert(&fold.m_nodes[i]);
  }
  btSoftBody& falling = still.add(flat(btScalar(0.6)));
  falling.setVelocity(btVector3(0, btScalar(-0.9) / kStep, 0));
  falling.m_cfg.kDP = 0;
  still.step();
  ASSERT_GT(falling.m_scontacts.size(), 20);
  for (int i = 0; i < falling.m_scontacts.size(); ++i) {
    const SContact& contact = falling.m_scontacts[i];
    const bool is_at_bend = contact.m_node->m_q.x() < kCell / 2;
    EXPECT_TRUE(is_at_bend || upper.contains(contact.m_face->m_n[0])) << i;
  }
}

}  // namespace
}  // namespace softcd::test
