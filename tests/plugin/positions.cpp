#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

/// Returns a scene on a coarse grid, so that positions in double survive large offsets unchanged.
Scene coarse_scene(Detection detection, std::uint32_t triangle_count = 300) {
  Scene scene;
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions options;
    options.triangle_count = triangle_count;
    options.half_extent = 2.0;
    options.size_ratio = 30.0;
    options.joined_share = 0.3;
    options.grid_bits = 12;
    options.seed = 60 + i;
    const Mesh mesh = triangle_soup(options);
    Positions3 end = jittered(mesh.positions, 0.2, i);
    snap_to_grid(end, 12);
    scene.push_back(moving(mesh, end, everything(detection == Detection::dcd ? 0.015625F : 0.0F)));
  }
  return scene;
}

Scene transformed(Scene scene, double scale, Vec3d offset) {
  for (SceneBody& body : scene) {
    body.x_t0 = translated(contracted(body.x_t0, scale), offset);
    body.x_t1 = translated(contracted(body.x_t1, scale), offset);
    body.settings.margin *= static_cast<float>(scale);
  }
  return scene;
}

template <class X>
constexpr bool kMayBeSet = std::is_invocable_v<void (softcd::Scene::*)(BodyId, Positions), softcd::Scene&, BodyId, X>&&
    std::is_constructible_v<Positions, X>;

// Memory that is read later must outlive the call.
static_assert(kMayBeSet<std::vector<Vec3f>&> && kMayBeSet<const std::vector<Vec3d>&>);
static_assert(!kMayBeSet<std::vector<Vec3f>> && !kMayBeSet<std::vector<Vec3d>> && !kMayBeSet<const std::vector<Vec3d>>);
static_assert(kMayBeSet<Span<const Vec3f>> && kMayBeSet<Span<const Vec3d>> && kMayBeSet<Span<const Vec3d>&>);
static_assert(kMayBeSet<Positions> && kMayBeSet<const Positions&>);
static_assert(std::is_constructible_v<Positions, Span<Vec3f>> && std::is_constructible_v<Positions, std::span<Vec3d>> &&
              std::is_constructible_v<Positions, std::span<const Vec3d>>);
static_assert(std::is_constructible_v<Positions, std::array<Vec3f, 3>&> &&
              !std::is_constructible_v<Positions, std::array<Vec3f, 3>>);
static_assert(std::is_constructible_v<Positions, const float*, std::size_t, std::size_t> &&
              std::is_constructible_v<Positions, double*, std::size_t, std::size_t>);

class PositionKinds : public testing::TestWithParam<Detection> {};

template <class T>
struct Node {
  std::uint64_t before = 0xFFFFFFFFFFFFFFFFU;
  T x[3];
  T other[5] = {NAN, NAN, NAN, NAN, NAN};
};

template <class T>
std::vector<Node<T>> nodes_of(const Positions3& positions) {
  std::vector<Node<T>> nodes;
  for (const Vec3d& p : positions) {
    Node<T> node;
    node.x[0] = static_cast<T>(p.x);
    node.x[1] = static_cast<T>(p.y);
    node.x[2] = static_cast<T>(p.z);
    nodes.push_back(node);
  }
  return nodes;
}

template <class T>
void expect_same_from_nodes(const Scene& scene, Detection detection) {
  const std::vector<Contact> expected = detect_once(scene, test_options(detection));
  ASSERT_FALSE(expected.empty());
  LoadedScene loaded = load(scene, test_options(detection));
  std::vector<std::vector<Node<T>>> nodes;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    nodes.push_back(nodes_of<T>(scene[i].x_t0));
    nodes.push_back(nodes_of<T>(scene[i].x_t1));
    const std::vector<Node<T>>& t0 = nodes[2 * i];
    const std::vector<Node<T>>& t1 = nodes[2 * i + 1];
    loaded.pipeline.scene.set_positions(loaded.ids[i], Positions(t0[0].x, t0.size(), sizeof(Node<T>)),
                                        Positions(t1[0].x, t1.size(), sizeof(Node<T>)));
  }
  EXPECT_TRUE(identical(expected, loaded.pipeline.detect()));
}

TEST_P(PositionKinds, float_and_double_nodes_of_a_struct) {
  expect_same_from_nodes<float>(coarse_scene(GetParam()), GetParam());
  expect_same_from_nodes<double>(coarse_scene(GetParam()), GetParam());
}

TEST_P(PositionKinds, one_body_in_float_one_in_double) {
  const Scene scene = coarse_scene(GetParam());
  LoadedScene loaded = load(scene, test_options(GetParam()));
  std::vector<Vec3f> t0;
  std::vector<Vec3f> t1;
  for (const Vec3d& p : scene[1].x_t0) t0.push_back(vec3_cast<float>(p));
  for (const Vec3d& p : scene[1].x_t1) t1.push_back(vec3_cast<float>(p));
  loaded.pipeline.scene.set_positions(loaded.ids[1], t0, t1);
  EXPECT_TRUE(identical(detect_once(scene, test_options(GetParam())), loaded.pipeline.detect()));
}

TEST_P(PositionKinds, are_read_when_the_detection_starts) {
  const Scene scene = coarse_scene(GetParam());
  LoadedScene loaded = load(scene, test_options(GetParam()));
  Positions3 x(scene[0].x_t1.size(), Vec3d{NAN, NAN, NAN});
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t0, x);
  x = scene[0].x_t1;
  Ticket ticket = loaded.pipeline.query.start();
  x.assign(x.size(), Vec3d{NAN, NAN, NAN});
  EXPECT_TRUE(identical(detect_once(scene, test_options(GetParam())), ticket.wait()));
}

// The memory may be gone once the detection after set_positions has started. A second detection must not need it.
TEST_P(PositionKinds, are_not_read_again) {
  const Scene scene = coarse_scene(GetParam());
  LoadedScene loaded = load(scene, test_options(GetParam()));
  auto x = std::make_unique<Positions3>(scene[0].x_t1);
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t0, *x);
  loaded.pipeline.detect();
  x->assign(x->size(), Vec3d{NAN, NAN, NAN});
  EXPECT_TRUE(identical(detect_once(scene, test_options(GetParam())), loaded.pipeline.detect()));
  EXPECT_EQ(loaded.pipeline.query.statistics().left_out_triangles, 0U);
}

TEST_P(PositionKinds, one_address_with_two_strides_is_two_ends) {
  const Scene scene = coarse_scene(GetParam());
  LoadedScene loaded = load(scene, test_options(GetParam()));
  // The second end's nodes lie between the first one's.
  const std::size_t count = scene[0].x_t1.size();
  Positions3 nodes = jittered(Positions3(3 * count, scene[0].x_t1[0]), 0.5, 3);
  snap_to_grid(nodes, 12);
  Scene expected = scene;
  for (std::size_t v = 0; v < count; ++v) {
    expected[0].x_t0[v] = nodes[2 * v];
    expected[0].x_t1[v] = nodes[3 * v];
  }
  loaded.pipeline.scene.set_positions(loaded.ids[0], Positions(&nodes[0].x, count, 2 * sizeof(Vec3d)),
                                      Positions(&nodes[0].x, count, 3 * sizeof(Vec3d)));
  const std::vector<Contact> contacts = detect_once(expected, test_options(GetParam()));
  EXPECT_FALSE(identical(contacts, detect_once(scene, test_options(GetParam()))));
  EXPECT_TRUE(identical(contacts, loaded.pipeline.detect()));
}

// Far from the origin doubles are rounded relative to the scene's origin. A second detection must round them alike,
// whichever bodies were set in between.
TEST_P(PositionKinds, a_second_detection_of_the_same_positions_has_the_same_bytes) {
  PipelineOptions options = test_options(GetParam());
  options.accuracy = Accuracy::conservative;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Scene scene;
    for (std::uint64_t i = 0; i < 2; ++i) {
      const Mesh sheet = moved(crumpled_cloth(4, 4, 0.37, 0.031, 2 * seed + i), {11.3, -23.7, 0.01 * double(i)});
      scene.push_back(moving(sheet, jittered(sheet.positions, 0.013, seed), everything(0.0173F)));
    }
    LoadedScene loaded = load(scene, options);
    const Span<const Contact> contacts = loaded.pipeline.detect();
    const std::vector<Contact> first(contacts.begin(), contacts.end());
    ASSERT_FALSE(first.empty());
    EXPECT_TRUE(identical(first, loaded.pipeline.detect())) << "scene " << seed;
    loaded.pipeline.scene.set_positions(loaded.ids[1], scene[1].x_t0, scene[1].x_t1);
    EXPECT_TRUE(identical(first, loaded.pipeline.detect())) << "scene " << seed << ", one body set again";

    const Positions3 elsewhere = translated(scene[1].x_t0, {900, 0, 0});
    loaded.pipeline.scene.set_positions(loaded.ids[1], elsewhere);
    loaded.pipeline.detect();
    loaded.pipeline.scene.set_positions(loaded.ids[1], scene[1].x_t0, scene[1].x_t1);
    EXPECT_TRUE(identical(first, loaded.pipeline.detect())) << "scene " << seed << ", with another origin in between";
  }
}

TEST_P(PositionKinds, one_end_means_at_rest) {
  Scene scene = coarse_scene(GetParam());
  LoadedScene loaded = load(scene, test_options(GetParam()));
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t1);
  scene[0].x_t0 = scene[0].x_t1;
  EXPECT_TRUE(identical(detect_once(scene, test_options(GetParam())), loaded.pipeline.detect()));
}

TEST_P(PositionKinds, far_from_the_origin) {
  const Scene scene = coarse_scene(GetParam());
  const std::vector<Contact> expected = detect_once(scene, test_options(GetParam()));
  ASSERT_FALSE(expected.empty());
  for (const double offset : {1e3, 1e4, 1e5, 1e6, 1e7}) {
    const std::vector<Contact> found =
        detect_once(transformed(scene, 1.0, {offset, -0.5 * offset, 2.0 * offset}), test_options(GetParam()));
    EXPECT_TRUE(identical(expected, found)) << "offset " << offset;
  }
}

TEST_P(PositionKinds, in_any_unit) {
  const Scene scene = coarse_scene(GetParam());
  const std::vector<FeaturePair> expected = features_of(detect_once(scene, test_options(GetParam())));
  for (const int exponent : {-60, -20, -10, -1, 1, 10, 20, 60}) {
    const std::vector<Contact> found =
        detect_once(transformed(scene, std::ldexp(1.0, exponent), {0, 0, 0}), test_options(GetParam()));
    EXPECT_EQ(features_of(found), expected) << "scale 2^" << exponent;
  }
}

// Positions are rounded, which decides about features that nearly touch.
TEST_P(PositionKinds, decimal_scales_and_offsets) {
  const Scene scene = coarse_scene(GetParam(), 120);
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
    const Scene other = transformed(scene, scale, {3.3 * scale, -7.7 * scale, 1.1 * scale});
    SCOPED_TRACE(scale);
    const double rounding = 16.0 * scale * 0x1p-24;
    if (GetParam() == Detection::dcd) {
      DiscreteRules rules;
      rules.absolute_band = rounding;
      EXPECT_GT(expect_discrete_contacts(other, test_options(Detection::dcd), rules), 150U);
    } else {
      PipelineOptions options = test_options(Detection::ccd);
      options.accuracy = Accuracy::conservative;
      EXPECT_GT(expect_continuous_contacts(other, options, {}, rounding), 150U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PositionKinds, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

// The scene's origin follows its bodies. One that rests has to be where it was at both ends of the step.
TEST(RestingBodies, are_met_wherever_the_origin_moves) {
  const Mesh floor = moved(grid_cloth(5, 5, 0.37), {1000.1, 0.2, 0.3});
  const Mesh leaf = moved(grid_cloth(3, 3, 0.13), {1000.5, 0.6, 0.5});
  Positions3 below = leaf.positions;
  for (Vec3d& p : below) p.z -= 0.7;
  Scene scene{still(floor, {}), moving(leaf, below, {}), still(leaf, {})};
  const PipelineOptions options = test_options(Detection::ccd);
  LoadedScene loaded = load(scene, options);
  loaded.pipeline.scene.set_positions(loaded.ids[0], scene[0].x_t1);
  EXPECT_FALSE(loaded.pipeline.detect().empty());
  for (const double x : {-1000.0, -300.0, 500.0}) {
    for (Positions3* const end : {&scene[2].x_t0, &scene[2].x_t1}) *end = translated(leaf.positions, {x, 0, 0});
    loaded.pipeline.scene.set_positions(loaded.ids[2], scene[2].x_t1);
    const std::vector<Contact> expected = detect_once(scene, options);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << x;
  }
}

}  // namespace
}  // namespace softcd::test
