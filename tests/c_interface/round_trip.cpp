#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "../../plugin/src/c_fields.hpp"
#include "c_client.h"
#include "handles.hpp"
#include "mesh_generators.hpp"
#include "scene.hpp"

// Results through C are those of the C++ interface, to the last byte.
namespace softcd::test {
namespace {

Scene touching_scene() {
  return {still(crumpled_cloth(12, 10, 0.25, 0.05, 1), everything(0.04F)),
          moving(moved(grid_cloth(8, 8, 0.25), {0.1, 0.1, 0.06}),
                 translated(grid_cloth(8, 8, 0.25).positions, {0.15, 0.1, -0.02}), everything(0.05F)),
          still(moved(icosphere(1, 0.3), {0.4, 0.4, 0.1}), everything(0.03F))};
}

/// Vertices of three scalars each, `kPadding` of them between two vertices.
template <class Scalar>
class Packed {
 public:
  explicit Packed(const Positions3& x) : count_(x.size()) {
    for (const Vec3d& p : x) {
      for (int axis = 0; axis < 3; ++axis) data_.push_back(static_cast<Scalar>(p[axis]));
      data_.resize(data_.size() + kPadding, Scalar(1e30));
    }
  }
  softcd_positions to_c() const {
    const softcd_scalar scalar = sizeof(Scalar) == sizeof(float) ? SOFTCD_FLOAT32 : SOFTCD_FLOAT64;
    return {sizeof(softcd_positions), scalar, SOFTCD_HOST, data_.data(), count_, kStride, nullptr};
  }
  Positions to_cpp() const { return {data_.data(), count_, kStride}; }

 private:
  static constexpr std::size_t kPadding = 2;
  static constexpr std::size_t kStride = (3 + kPadding) * sizeof(Scalar);
  std::vector<Scalar> data_;
  std::size_t count_;
};

template <class Scalar>
struct Ends {
  explicit Ends(const Scene& scene) {
    for (const SceneBody& body : scene) {
      t0.emplace_back(body.x_t0);
      t1.emplace_back(body.x_t1);
    }
  }
  std::vector<Packed<Scalar>> t0, t1;
};

template <class Scalar>
std::vector<Contact> detect_in_cpp(const Scene& scene, const Ends<Scalar>& ends, const QueryOptions& options) {
  softcd::Scene bodies(SceneOptions{test_options(options.detection).backend});
  for (std::size_t b = 0; b < scene.size(); ++b) {
    const BodyId id =
        bodies.add_body({scene[b].triangles, static_cast<std::uint32_t>(scene[b].x_t1.size()), scene[b].settings});
    bodies.set_positions(id, ends.t0[b].to_cpp(), ends.t1[b].to_cpp());
  }
  Query query(bodies, options);
  const Span<const Contact> contacts = query.detect();
  return {contacts.begin(), contacts.end()};
}

template <class Scalar>
std::vector<softcd_contact> detect_in_c(const Scene& scene, const Ends<Scalar>& ends, const QueryOptions& options) {
  std::vector<client_body> bodies;
  for (std::size_t b = 0; b < scene.size(); ++b) {
    bodies.push_back(
        {&scene[b].triangles[0].v[0], scene[b].triangles.size(), static_cast<std::uint32_t>(scene[b].x_t1.size()),
         c_interface::to_c<softcd_body_settings>(scene[b].settings), ends.t0[b].to_c(), ends.t1[b].to_c()});
  }
  softcd_scene_options scene_options{};
  EXPECT_EQ(softcd_scene_options_init(&scene_options, sizeof scene_options), SOFTCD_OK);
  scene_options.backend = static_cast<softcd_backend>(test_options(options.detection).backend);
  const softcd_query_options query_options = c_interface::to_c<softcd_query_options>(options);
  std::vector<softcd_contact> contacts(100000);
  std::uint64_t count = 0;
  EXPECT_EQ(client_detect(bodies.data(), bodies.size(), &scene_options, &query_options, contacts.data(),
                          contacts.size(), &count),
            SOFTCD_OK)
      << softcd_last_error();
  contacts.resize(count);
  return contacts;
}

template <class Scalar>
void expect_same_bytes(const QueryOptions& options) {
  const Scene scene = touching_scene();
  const Ends<Scalar> ends(scene);
  const std::vector<Contact> expected = detect_in_cpp(scene, ends, options);
  const std::vector<softcd_contact> found = detect_in_c(scene, ends, options);
  ASSERT_GT(expected.size(), 20U);
  ASSERT_EQ(found.size(), expected.size());
  EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(softcd_contact)), 0);
}

TEST(CRoundTrip, contacts_have_the_bytes_of_the_cpp_interface) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    QueryOptions options;
    options.detection = detection;
    expect_same_bytes<float>(options);
    expect_same_bytes<double>(options);
  }
}

struct OptionCase {
  const char* name;
  QueryOptions options;
  bool changes_contacts;  ///< of the scene, where it arrives
};

template <class Value>
OptionCase with(const char* name, Value QueryOptions::*option, Value value, bool changes_contacts) {
  OptionCase result{name, {}, changes_contacts};
  result.options.*option = value;
  return result;
}

TEST(CRoundTrip, each_option_arrives) {
  const Scene scene = touching_scene();
  const Ends<double> ends(scene);
  const std::vector<softcd_contact> by_default = detect_in_c(scene, ends, {});
  std::vector<OptionCase> cases = {with("detection", &QueryOptions::detection, Detection::ccd, true),
                                   with("accuracy", &QueryOptions::accuracy, Accuracy::fast, true),
                                   with("broad_phase", &QueryOptions::broad_phase, BroadPhase::uniform, false),
                                   with("contact_rule", &QueryOptions::contact_rule, ContactRule::slab, true),
                                   with("step_end", &QueryOptions::step_end, StepEnd::t0, true),
                                   with("subdivision", &QueryOptions::subdivision, false, false),
                                   with("cell_size_factor", &QueryOptions::cell_size_factor, 2.2F, false),
                                   with("motion_margin", &QueryOptions::motion_margin, 0.5F, true),
                                   with("margins", &QueryOptions::margins, false, true),
                                   with("neighbour_filters", &QueryOptions::neighbour_filters, false, false),
                                   with("reuse_pairs", &QueryOptions::reuse_pairs, false, false),
                                   with("vertex_triangle", &QueryOptions::features, Features{false, true}, true),
                                   with("edge_edge", &QueryOptions::features, Features{true, false}, true)};
  for (const OptionCase& with_option : cases) {
    SCOPED_TRACE(with_option.name);
    const std::vector<Contact> expected = detect_in_cpp(scene, ends, with_option.options);
    const std::vector<softcd_contact> found = detect_in_c(scene, ends, with_option.options);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_TRUE(found.empty() ||
                std::memcmp(found.data(), expected.data(), found.size() * sizeof(softcd_contact)) == 0);
    const bool differs = found.size() != by_default.size() ||
                         std::memcmp(found.data(), by_default.data(), found.size() * sizeof(softcd_contact)) != 0;
    EXPECT_EQ(differs, with_option.changes_contacts);
  }
}

/// The probes of both interfaces on the same bodies.
struct BothProbes {
  explicit BothProbes(const Scene& scene)
      : ends(scene), bodies(SceneOptions{test_options(Detection::dcd).backend}), in_cpp(bodies) {
    softcd_scene_options options{};
    EXPECT_EQ(softcd_scene_options_init(&options, sizeof options), SOFTCD_OK);
    options.backend = static_cast<softcd_backend>(bodies.options().backend);
    softcd_scene* made_scene = nullptr;
    softcd_probe* made_probe = nullptr;
    EXPECT_EQ(softcd_scene_create(&options, &made_scene), SOFTCD_OK) << softcd_last_error();
    bodies_in_c.reset(made_scene);
    EXPECT_EQ(softcd_probe_create(made_scene, SOFTCD_T1, &made_probe), SOFTCD_OK);
    in_c.reset(made_probe);
    for (std::size_t b = 0; b < scene.size(); ++b) {
      const auto vertex_count = static_cast<std::uint32_t>(scene[b].x_t1.size());
      const BodyId id = bodies.add_body({scene[b].triangles, vertex_count, scene[b].settings});
      bodies.set_positions(id, ends.t1[b].to_cpp());
      softcd_body body = SOFTCD_NO_BODY;
      EXPECT_EQ(softcd_scene_add_body(made_scene, &scene[b].triangles[0].v[0], scene[b].triangles.size(), vertex_count,
                                      nullptr, &body),
                SOFTCD_OK);
      EXPECT_EQ(body, id.value);
      const softcd_positions x = ends.t1[b].to_c();
      EXPECT_EQ(softcd_scene_set_positions(made_scene, body, nullptr, &x), SOFTCD_OK);
    }
  }

  Ends<double> ends;
  softcd::Scene bodies;
  Probe in_cpp;
  ScenePointer bodies_in_c;
  ProbePointer in_c;
};

template <class Answer, class Expected>
void expect_same_bytes(const Answer* answers, Span<const Expected> expected) {
  static_assert(sizeof(Answer) == sizeof(Expected));
  ASSERT_GT(expected.size(), 0U);
  EXPECT_EQ(std::memcmp(answers, expected.data(), expected.size() * sizeof(Answer)), 0);
}
template <class Answer, class Expected>
void expect_same_lists(const std::uint64_t* begins, const Answer* answers, const AnswerLists<Expected>& expected) {
  EXPECT_TRUE(std::equal(expected.begins().begin(), expected.begins().end(), begins));
  expect_same_bytes(answers, expected.all());
}

TEST(CRoundTrip, answers_about_bodies_are_those_of_cpp) {
  BothProbes probes(touching_scene());
  const std::vector<ProbeBodies> pairs = {{{0}, {1}}, {{2}, {}}, {{0}, {0}}, {{}, {}}};
  const auto* const pairs_in_c = reinterpret_cast<const softcd_body_pair*>(pairs.data());
  const softcd_body_distance* distances = nullptr;
  ASSERT_EQ(softcd_probe_distances(probes.in_c.get(), pairs_in_c, pairs.size(), &distances), SOFTCD_OK);
  expect_same_bytes(distances, probes.in_cpp.distances(pairs));
  const std::uint64_t* begins = nullptr;
  const softcd_intersection* intersections = nullptr;
  ASSERT_EQ(softcd_probe_intersections(probes.in_c.get(), pairs_in_c, pairs.size(), &begins, &intersections),
            SOFTCD_OK);
  expect_same_lists(begins, intersections, probes.in_cpp.intersections(pairs));
  for (const ProbeBodies& pair : pairs) {
    const softcd_body_pair in_c = {pair.a.value, pair.b.value};
    std::uint32_t has_some = 2;
    ASSERT_EQ(softcd_probe_has_intersections(probes.in_c.get(), &in_c, &has_some), SOFTCD_OK);
    EXPECT_EQ(has_some, probes.in_cpp.has_intersections(pair) ? 1U : 0U);
  }
}

TEST(CRoundTrip, intersection_regions_are_those_of_cpp) {
  BothProbes probes(touching_scene());
  softcd_intersection_regions in_c;
  ASSERT_EQ(softcd_probe_intersection_regions(probes.in_c.get(), nullptr, &in_c), SOFTCD_OK);
  const IntersectionRegions expected = probes.in_cpp.intersection_regions();
  ASSERT_EQ(in_c.region_count, expected.regions.size());
  ASSERT_EQ(in_c.curve_count, expected.curves.size());
  ASSERT_GT(in_c.curve_count, 0U);
  EXPECT_EQ(in_c.touching_pairs, expected.touching_pairs);
  for (std::size_t i = 0; i < expected.regions.size(); ++i) {
    EXPECT_EQ(in_c.regions[i].body, expected.regions[i].body.value);
    EXPECT_EQ(in_c.regions[i].kind, static_cast<softcd_region_kind>(expected.regions[i].kind));
    EXPECT_EQ(in_c.regions[i].area, expected.regions[i].area);
    EXPECT_EQ(in_c.regions[i].curve_count, expected.regions[i].curve_count);
  }
  for (std::size_t i = 0; i < expected.vertices.size(); ++i) {
    EXPECT_EQ(in_c.vertices[i].vertex, expected.vertices[i].vertex);
    EXPECT_EQ(in_c.vertices[i].distance, expected.vertices[i].distance);
  }
  EXPECT_TRUE(std::equal(expected.triangles.begin(), expected.triangles.end(), in_c.triangles));
  EXPECT_TRUE(std::equal(expected.region_curves.begin(), expected.region_curves.end(), in_c.region_curves));
  for (std::size_t i = 0; i < expected.points.size(); ++i) {
    EXPECT_EQ(in_c.points[i].position[1], expected.points[i].position.y);
    EXPECT_EQ(in_c.points[i].triangle, expected.points[i].triangle);
  }
  const softcd_body_pair absent = {99, 0};
  EXPECT_EQ(softcd_probe_intersection_regions(probes.in_c.get(), &absent, &in_c), SOFTCD_INVALID_INPUT);
  EXPECT_EQ(in_c.region_count, 0U);
  EXPECT_EQ(softcd_probe_intersection_regions(probes.in_c.get(), nullptr, nullptr), SOFTCD_INVALID_INPUT);
}

TEST(CRoundTrip, answers_about_changes_and_shapes_are_those_of_cpp) {
  const Scene scene = touching_scene();
  BothProbes probes(scene);
  const std::vector<std::uint32_t> removed = {3, 0};
  const auto new_vertex = static_cast<std::uint32_t>(scene[0].x_t1.size());
  const std::vector<Triangle> added = {{{0, 1, new_vertex}}, {{5, 40, 61}}};
  const std::vector<Vec3d> new_vertices = {{0.4, 0.4, 0.2}};
  const std::vector<ProbeChange> changes = {{{0}, removed, added, new_vertices}, {{1}, {}, {added.data() + 1, 1}, {}}};
  std::vector<softcd_change> in_c;
  for (const ProbeChange& change : changes) {
    in_c.push_back({change.body.value, change.removed.data(), change.removed.size(),
                    change.added.empty() ? nullptr : &change.added[0].v[0], change.added.size(),
                    change.new_vertices.empty() ? nullptr : &change.new_vertices[0].x, change.new_vertices.size()});
  }
  const std::uint64_t* begins = nullptr;
  const softcd_change_intersection* intersections = nullptr;
  ASSERT_EQ(softcd_probe_intersections_after(probes.in_c.get(), in_c.data(), in_c.size(), &begins, &intersections),
            SOFTCD_OK)
      << softcd_last_error();
  expect_same_lists(begins, intersections, probes.in_cpp.intersections_after(changes));

  const std::vector<ProbeCapsule> capsules = {{{0, 0, 0}, {1, 1, 0}, 0.1}, {{0.4, 0.4, 0.1}, {0.4, 0.4, 0.1}, 0.35}};
  const softcd_overlap* overlaps = nullptr;
  ASSERT_EQ(softcd_probe_capsule_overlaps(probes.in_c.get(), reinterpret_cast<const softcd_capsule*>(capsules.data()),
                                          capsules.size(), &begins, &overlaps),
            SOFTCD_OK);
  expect_same_lists(begins, overlaps, probes.in_cpp.overlaps(capsules));

  const std::vector<Vec3d> corners = {{0, 0, 0}, {1, 1, 0}, {0.2, 0.9, 0.3}, {0.5, 0.1, -0.4}, {0.4, 0.4, 0.1}};
  const std::vector<ProbeHull> hulls = {{{corners.data(), 2}, 0.1}, {}, {corners}, {{corners.data() + 4, 1}, 0.35}};
  std::vector<softcd_hull> hulls_in_c;
  for (const ProbeHull& hull : hulls) {
    hulls_in_c.push_back({hull.points.empty() ? nullptr : &hull.points[0].x, hull.points.size(), hull.radius});
  }
  ASSERT_EQ(softcd_probe_hull_overlaps(probes.in_c.get(), hulls_in_c.data(), hulls_in_c.size(), &begins, &overlaps),
            SOFTCD_OK)
      << softcd_last_error();
  expect_same_lists(begins, overlaps, probes.in_cpp.overlaps(hulls));
}

TEST(CRoundTrip, structs_have_one_layout_in_both_languages) {
#define SIZE_OF(type) sizeof(type),
  const std::vector<std::size_t> expected = {SOFTCD_CLIENT_STRUCTS(SIZE_OF)};
#undef SIZE_OF
  std::vector<std::size_t> sizes(expected.size());
  ASSERT_EQ(client_struct_sizes(sizes.data(), sizes.size()), sizes.size());
  EXPECT_EQ(sizes, expected);
}

}  // namespace
}  // namespace softcd::test
