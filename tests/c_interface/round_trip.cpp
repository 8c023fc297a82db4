#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "c_client.h"
#include "mesh_generators.hpp"
#include "scene.hpp"

// What goes through C comes out as it does of the C++ interface, to the last byte.
namespace softcd::test {
namespace {

Scene touching_scene() {
  return {still(crumpled_cloth(12, 10, 0.25, 0.05, 1), everything(0.04F)),
          moving(moved(grid_cloth(8, 8, 0.25), {0.1, 0.1, 0.06}),
                 translated(grid_cloth(8, 8, 0.25).positions, {0.15, 0.1, -0.02}), everything(0.05F)),
          still(moved(icosphere(1, 0.3), {0.4, 0.4, 0.1}), everything(0.03F))};
}

softcd_body_settings to_c(const BodySettings& settings) {
  softcd_body_settings c{};
  EXPECT_EQ(softcd_body_settings_init(&c, sizeof c), SOFTCD_OK);
  c.margin = settings.margin;
  c.filter_group = settings.filter_group;
  c.filter_mask = settings.filter_mask;
  c.self_collision = settings.self_collision;
  c.kinematic = settings.kinematic;
  c.vertex_triangle = settings.features.vertex_triangle;
  c.edge_edge = settings.features.edge_edge;
  return c;
}

softcd_query_options to_c(const QueryOptions& options) {
  softcd_query_options c{};
  EXPECT_EQ(softcd_query_options_init(&c, sizeof c), SOFTCD_OK);
  c.detection = static_cast<softcd_detection>(options.detection);
  c.accuracy = static_cast<softcd_accuracy>(options.accuracy);
  c.broad_phase = static_cast<softcd_broad_phase>(options.broad_phase);
  c.contact_rule = static_cast<softcd_contact_rule>(options.contact_rule);
  c.step_end = static_cast<softcd_step_end>(options.step_end);
  c.subdivision = options.subdivision;
  c.lambda = options.lambda;
  c.motion_margin = options.motion_margin;
  c.margins = options.margins;
  c.vertex_triangle = options.features.vertex_triangle;
  c.edge_edge = options.features.edge_edge;
  c.reuse_pairs = options.reuse_pairs;
  c.contacts_on_device = options.contacts_on_device;
  return c;
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
    bodies.push_back({&scene[b].triangles[0].v[0], scene[b].triangles.size(),
                      static_cast<std::uint32_t>(scene[b].x_t1.size()), to_c(scene[b].settings), ends.t0[b].to_c(),
                      ends.t1[b].to_c()});
  }
  softcd_scene_options scene_options{};
  EXPECT_EQ(softcd_scene_options_init(&scene_options, sizeof scene_options), SOFTCD_OK);
  scene_options.backend = static_cast<softcd_backend>(test_options(options.detection).backend);
  const softcd_query_options query_options = to_c(options);
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
                                   with("lambda", &QueryOptions::lambda, 2.2F, false),
                                   with("motion_margin", &QueryOptions::motion_margin, 0.5F, true),
                                   with("margins", &QueryOptions::margins, false, true),
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

TEST(CRoundTrip, structs_have_one_layout_in_both_languages) {
  const std::vector<std::size_t> expected = {
      sizeof(softcd_scene_options), sizeof(softcd_body_settings), sizeof(softcd_positions),
      sizeof(softcd_query_options), sizeof(softcd_contact),       sizeof(softcd_statistics),
      sizeof(softcd_ray),           sizeof(softcd_ray_hit),       sizeof(softcd_point),
      sizeof(softcd_closest_point), sizeof(softcd_sphere),        sizeof(softcd_box),
      sizeof(softcd_overlap),       sizeof(softcd_oriented_box),  sizeof(softcd_mesh)};
  std::vector<std::size_t> sizes(expected.size());
  ASSERT_EQ(client_struct_sizes(sizes.data(), sizes.size()), sizes.size());
  EXPECT_EQ(sizes, expected);
}

}  // namespace
}  // namespace softcd::test
