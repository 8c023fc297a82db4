#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "device_memory.hpp"
#include "handles.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {
namespace {

using CCalls = TwoTriangles;

TEST_F(CCalls, the_library_has_the_headers_version) {
  EXPECT_EQ(softcd_version(), static_cast<std::uint32_t>(SOFTCD_VERSION));
}

TEST_F(CCalls, defaults_are_those_of_the_cpp_interface) {
  softcd_query_options options{};
  ASSERT_EQ(softcd_query_options_init(&options, sizeof options), SOFTCD_OK);
  EXPECT_EQ(options.struct_size, sizeof options);
  EXPECT_EQ(options.accuracy, static_cast<softcd_accuracy>(SOFTCD_ACCURACY_AUTOMATIC));
  EXPECT_EQ(options.accuracy, static_cast<softcd_accuracy>(QueryOptions().accuracy));
  EXPECT_TRUE(options.margins && options.subdivision && options.vertex_triangle && options.edge_edge);
  softcd_scene_options scene_options{};
  ASSERT_EQ(softcd_scene_options_init(&scene_options, sizeof scene_options), SOFTCD_OK);
  EXPECT_EQ(scene_options.cuda_device, -1);
  softcd_body_settings settings{};
  ASSERT_EQ(softcd_body_settings_init(&settings, sizeof settings), SOFTCD_OK);
  EXPECT_EQ(settings.filter_mask, BodySettings().filter_mask);
  EXPECT_TRUE(settings.vertex_triangle && settings.edge_edge && settings.self_collision);
  EXPECT_EQ(settings.self_collision != 0, BodySettings().self_collision);
  EXPECT_EQ(settings.edge_edge != 0, BodySettings().features.edge_edge);
  EXPECT_TRUE(options.neighbour_filters);
  EXPECT_EQ(settings.neighbour_rings, BodySettings().neighbour_rings);
}

TEST_F(CCalls, a_contact_says_who_touches_what) {
  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 0;
  ASSERT_EQ(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, &count), SOFTCD_OK);
  ASSERT_EQ(count, 1U);
  EXPECT_EQ(contacts[0].kind, SOFTCD_VERTEX_TRIANGLE);
  EXPECT_EQ(contacts[0].body_a, upper_);
  EXPECT_EQ(contacts[0].body_b, lower_);
  EXPECT_EQ(contacts[0].vertices[0], 0U);
  EXPECT_FLOAT_EQ(contacts[0].weights[1], 0.5F);
  EXPECT_FLOAT_EQ(contacts[0].normal[2], 1.0F);
  EXPECT_FLOAT_EQ(contacts[0].distance, 0.1F);
}

TEST_F(CCalls, bodies_change_and_go) {
  std::uint32_t has_body = 0;
  EXPECT_EQ(softcd_scene_has_body(scene(), upper_, &has_body), SOFTCD_OK);
  EXPECT_EQ(has_body, 1U);
  settings_.margin = 0;
  EXPECT_EQ(softcd_scene_set_settings(scene(), upper_, &settings_), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);  // the other's margin is 0.1 still
  EXPECT_EQ(softcd_scene_set_settings(scene(), lower_, nullptr), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);

  settings_.margin = 0.2F;
  const softcd_positions upper = positions(kUpper);
  EXPECT_EQ(softcd_scene_update_body(scene(), upper_, kTriangle, 1, 3, &settings_), SOFTCD_OK);
  EXPECT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &upper), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);

  EXPECT_EQ(softcd_scene_remove_body(scene(), upper_), SOFTCD_OK);
  EXPECT_EQ(softcd_scene_has_body(scene(), upper_, &has_body), SOFTCD_OK);
  EXPECT_EQ(has_body, 0U);
  EXPECT_EQ(detect(), 0U);
}

TEST_F(CCalls, ropes_touch_by_their_edges) {
  // 0.15 above the lower triangle: over its side {1, 2}, and over nothing else.
  constexpr float kRope[] = {0.2F, 0.2F, 5, 0.75F, 0.75F, 0.15F, 0.25F, 0.5F, 0.15F};
  constexpr std::uint32_t kSegments[] = {0, 1, 1, 2};
  const softcd_mesh rope = {sizeof rope, 3, nullptr, 0, kSegments, 2};
  settings_.edge_edge = 1;
  softcd_body body = SOFTCD_NO_BODY;
  ASSERT_EQ(softcd_scene_add_mesh(scene(), &rope, &settings_, &body), SOFTCD_OK) << softcd_last_error();
  const softcd_positions x = positions(kRope);
  ASSERT_EQ(softcd_scene_set_positions(scene(), body, nullptr, &x), SOFTCD_OK);
  ASSERT_EQ(softcd_scene_remove_body(scene(), upper_), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U) << "its end, over the triangle";
  ASSERT_EQ(softcd_scene_set_settings(scene(), lower_, &settings_), SOFTCD_OK);

  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 0;
  ASSERT_EQ(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, &count), SOFTCD_OK);
  ASSERT_EQ(count, 2U);
  const softcd_contact& crossing = contacts[0].kind == SOFTCD_EDGE_EDGE ? contacts[0] : contacts[1];
  EXPECT_EQ(crossing.body_a, lower_);
  EXPECT_EQ(crossing.body_b, body);
  EXPECT_EQ(crossing.feature_b, 1U);  // its second segment
  EXPECT_FLOAT_EQ(crossing.distance, 0.15F);

  const softcd_mesh shorter = {sizeof shorter, 3, nullptr, 0, kSegments, 1};
  ASSERT_EQ(softcd_scene_update_mesh(scene(), body, &shorter, &settings_, nullptr, 0), SOFTCD_OK);
  ASSERT_EQ(softcd_scene_set_positions(scene(), body, nullptr, &x), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
}

TEST_F(CCalls, a_mesh_is_changed_in_part) {
  constexpr float kFar[] = {0, 0, 9, 1, 0, 9, 0, 1, 9, 0.25F, 0.25F, 0.1F};
  // The first triangle is not among those that have changed, and not read.
  constexpr std::uint32_t kTriangles[] = {77, 78, 79, 1, 2, 3};
  constexpr std::uint32_t kChanged[] = {1};
  const softcd_mesh refined = {sizeof refined, 4, kTriangles, 2, nullptr, 0};
  softcd_positions x = positions(kFar);
  x.count = 4;
  ASSERT_EQ(softcd_scene_update_mesh(scene(), upper_, &refined, &settings_, kChanged, 1), SOFTCD_OK)
      << softcd_last_error();
  ASSERT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &x), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U) << "the new vertex, near the other body";

  const softcd_mesh coarser = {sizeof coarser, 3, kTriangles, 1, nullptr, 0};
  ASSERT_EQ(softcd_scene_update_mesh(scene(), upper_, &coarser, &settings_, kChanged, 0), SOFTCD_OK);
  x.count = 3;
  ASSERT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &x), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  EXPECT_EQ(softcd_scene_update_mesh(scene(), upper_, &coarser, &settings_, nullptr, 0), SOFTCD_INVALID_INPUT)
      << "all triangles are read";
}

TEST_F(CCalls, pairs_may_be_those_that_changed) {
  EXPECT_EQ(detect(), 1U);
  EXPECT_EQ(detect(SOFTCD_PAIRS_CHANGED), 0U);
  const softcd_positions lower = positions(kLower);
  EXPECT_EQ(softcd_scene_set_positions(scene(), lower_, nullptr, &lower), SOFTCD_OK);
  EXPECT_EQ(detect(SOFTCD_PAIRS_CHANGED), 1U);
}

TEST_F(CCalls, a_pair_filter_is_asked_with_its_data) {
  struct Asked {
    std::vector<std::pair<softcd_body, softcd_body>> pairs;
    std::uint32_t answer = 0;
  } asked;
  const softcd_pair_filter filter = [](void* data, softcd_body a, softcd_body b) {
    static_cast<Asked*>(data)->pairs.emplace_back(a, b);
    return static_cast<Asked*>(data)->answer;
  };
  ASSERT_EQ(softcd_query_set_pair_filter(query(), filter, &asked), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  asked.answer = 2;
  EXPECT_EQ(detect(), 1U);
  EXPECT_EQ(asked.pairs, (decltype(asked.pairs)(2, {lower_, upper_})));
  ASSERT_EQ(softcd_query_set_pair_filter(query(), nullptr, nullptr), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  EXPECT_EQ(asked.pairs.size(), 2U);
}

TEST_F(CCalls, pairs_of_bodies_are_ignored_or_the_only_ones) {
  const softcd_body_pair pair = {upper_, lower_};
  const softcd_body_pair other = {upper_, upper_};
  ASSERT_EQ(softcd_scene_set_ignored_pairs(scene(), &pair, 1), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  ASSERT_EQ(softcd_scene_set_ignored_pairs(scene(), nullptr, 0), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  ASSERT_EQ(softcd_query_set_only_pairs(query(), &other, 1), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  ASSERT_EQ(softcd_query_set_only_pairs(query(), &pair, 1), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  EXPECT_EQ(softcd_scene_set_ignored_pairs(scene(), nullptr, 1), SOFTCD_INVALID_INPUT);
}

TEST_F(CCalls, vertices_have_filters_and_places_at_rest) {
  const softcd_vertex_filter filters[3] = {{1, 0}, {1, 1}, {1, 1}};
  ASSERT_EQ(softcd_scene_set_vertex_filters(scene(), upper_, filters, 3), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  EXPECT_EQ(softcd_scene_set_vertex_filters(scene(), upper_, filters, 2), SOFTCD_INVALID_INPUT);
  ASSERT_EQ(softcd_scene_set_vertex_filters(scene(), upper_, nullptr, 0), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  settings_.self_collision = 1;
  settings_.rest_distance = 0.1F;
  settings_.neighbour_rings = 2;
  ASSERT_EQ(softcd_scene_set_settings(scene(), upper_, &settings_), SOFTCD_OK);
  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 0;
  EXPECT_EQ(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, &count), SOFTCD_INVALID_INPUT);
  const softcd_positions x = positions(kUpper);
  ASSERT_EQ(softcd_scene_set_rest_positions(scene(), upper_, &x), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  ASSERT_EQ(softcd_scene_set_rest_positions(scene(), upper_, nullptr), SOFTCD_OK);
  EXPECT_EQ(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, &count), SOFTCD_INVALID_INPUT);
}

TEST_F(CCalls, warnings_are_logged) {
  std::vector<std::string> warnings;
  const softcd_log log = [](void* data, softcd_log_level level, const char* text) {
    if (level == SOFTCD_LOG_WARNING) static_cast<std::vector<std::string>*>(data)->emplace_back(text);
  };
  ASSERT_EQ(softcd_scene_set_log(scene(), log, &warnings), SOFTCD_OK);
  float strays[9] = {NAN};
  const softcd_positions x = positions(strays);
  ASSERT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &x), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("vertex 0 is not finite"), std::string::npos) << warnings[0];
}

TEST_F(CCalls, statistics_are_of_the_last_detection) {
  detect();
  softcd_statistics statistics{};
  statistics.struct_size = sizeof statistics;
  ASSERT_EQ(softcd_query_statistics(query(), &statistics), SOFTCD_OK);
  EXPECT_EQ(statistics.struct_size, sizeof statistics);
  EXPECT_EQ(statistics.bodies, 2U);
  EXPECT_EQ(statistics.triangles, 2U);
  EXPECT_EQ(statistics.vertices, 6U);
  EXPECT_EQ(statistics.vt_contacts, 1U);
  EXPECT_EQ(statistics.ee_contacts, 0U);
  EXPECT_GT(statistics.total_ms, 0.0);
  softcd_backend backend = SOFTCD_BACKEND_AUTOMATIC;
  ASSERT_EQ(softcd_scene_backend(scene(), &backend), SOFTCD_OK);
  EXPECT_EQ(backend, statistics.backend);
  EXPECT_NE(backend, static_cast<softcd_backend>(SOFTCD_BACKEND_AUTOMATIC));
}

TEST_F(CCalls, options_are_changed_later) {
  softcd_query_options options{};
  ASSERT_EQ(softcd_query_options_init(&options, sizeof options), SOFTCD_OK);
  options.step_end = SOFTCD_T0;
  ASSERT_EQ(softcd_query_set_options(query(), &options), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);  // 0.2 is the sum of the margins
  options.margins = 0;
  ASSERT_EQ(softcd_query_set_options(query(), &options), SOFTCD_OK);
  EXPECT_EQ(detect(), 0U);
  ASSERT_EQ(softcd_query_set_options(query(), nullptr), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
  softcd_scene_options scene_options{};
  ASSERT_EQ(softcd_scene_options_init(&scene_options, sizeof scene_options), SOFTCD_OK);
  scene_options.backend = static_cast<softcd_backend>(backend_under_test());
  scene_options.max_threads = 1;
  ASSERT_EQ(softcd_scene_set_options(scene(), &scene_options), SOFTCD_OK);
  EXPECT_EQ(detect(), 1U);
}

/// Copies data from the GPU's memory.
template <class T>
std::vector<T> on_host(const T* data, std::size_t count = 1) {
  const std::vector<std::byte> bytes = read_device(Backend::cuda, data, count * sizeof(T));
  std::vector<T> read(count);
  std::memcpy(read.data(), bytes.data(), bytes.size());
  return read;
}

// On a GPU nothing passes the bus but the count.
TEST_F(CCalls, both_ends_may_stay_on_a_device) {
  const Backend backend = backend_under_test();
  if (backend != Backend::cuda) GTEST_SKIP() << "of a GPU";
  DeviceMemory lower(backend, sizeof kLower);
  DeviceMemory upper(backend, sizeof kUpper);
  lower.write(kLower, sizeof kLower);
  upper.write(kUpper, sizeof kUpper);
  softcd_positions x = positions(reinterpret_cast<const float*>(lower.data()));
  x.memory = SOFTCD_CUDA_DEVICE;
  ASSERT_EQ(softcd_scene_set_positions(scene(), lower_, nullptr, &x), SOFTCD_OK) << softcd_last_error();
  x.data = upper.data();
  ASSERT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &x), SOFTCD_OK) << softcd_last_error();

  softcd_query_options options{};
  ASSERT_EQ(softcd_query_options_init(&options, sizeof options), SOFTCD_OK);
  options.contacts_on_device = 1;
  ASSERT_EQ(softcd_query_set_options(query(), &options), SOFTCD_OK);
  softcd_pending_contacts pending{};
  softcd_device_contacts found{};
  pending.struct_size = sizeof pending;
  found.struct_size = sizeof found;
  for (int repetition = 0; repetition < 2; ++repetition) {  // lists have grown in the second one
    ASSERT_EQ(softcd_query_start(query(), SOFTCD_PAIRS_ALL), SOFTCD_OK) << softcd_last_error();
    ASSERT_EQ(softcd_query_on_device(query(), &pending), SOFTCD_OK) << softcd_last_error();
    ASSERT_EQ(softcd_query_wait_on_device(query(), &found), SOFTCD_OK) << softcd_last_error();
  }
  ASSERT_EQ(found.count, 1U);
  EXPECT_GE(found.device, 0);
  ASSERT_EQ(found.body_ids, 2U);
  const auto contact = on_host<softcd_contact>(found.data)[0];
  EXPECT_EQ(contact.body_a, upper_);
  EXPECT_EQ(contact.body_b, lower_);
  EXPECT_EQ(on_host<std::uint64_t>(found.body_begin, 5), (std::vector<std::uint64_t>{0, 0, 1, 1, 1}));
  EXPECT_EQ(pending.data, found.data);
  EXPECT_EQ(pending.body_begin, found.body_begin);
  EXPECT_EQ(pending.device, found.device);
  EXPECT_GE(pending.capacity, found.count);
  EXPECT_NE(pending.ready, nullptr);
  const auto counts = on_host<softcd_contact_counts>(pending.counts)[0];
  EXPECT_EQ(counts.contacts, 1U);
  EXPECT_EQ(counts.is_complete, 1U);
}

class CProbes : public TwoTriangles {
 protected:
  CProbes() {
    softcd_probe* created = nullptr;
    EXPECT_EQ(softcd_probe_create(scene(), SOFTCD_T1, &created), SOFTCD_OK);
    probe_.reset(created);
  }
  softcd_probe* probe() const { return probe_.get(); }

  ProbePointer probe_;
};

TEST_F(CProbes, rays_meet_triangles) {
  const softcd_ray rays[] = {{{0.3, 0.3, 9}, {0, 0, -1}, 0, INFINITY}, {{3, 3, 9}, {0, 0, -1}, 0, INFINITY}};
  const softcd_ray_hit* hits = nullptr;
  ASSERT_EQ(softcd_probe_first_hits(probe(), rays, 2, &hits), SOFTCD_OK);
  EXPECT_EQ(hits[0].body, upper_);
  EXPECT_EQ(hits[1].body, SOFTCD_NO_BODY);
  EXPECT_EQ(hits[1].t, INFINITY);
  const std::uint64_t* begins = nullptr;
  ASSERT_EQ(softcd_probe_all_hits(probe(), rays, 2, &begins, &hits), SOFTCD_OK);
  EXPECT_EQ(begins[0], 0U);
  ASSERT_EQ(begins[1], 2U);
  EXPECT_EQ(begins[2], 2U);
  EXPECT_LT(hits[0].t, hits[1].t);
  EXPECT_DOUBLE_EQ(hits[1].t, 9.0);
  EXPECT_FLOAT_EQ(std::abs(hits[1].normal[2]), 1.0F);
}

TEST_F(CProbes, nearest_points_and_overlaps) {
  const softcd_point points[] = {{{0.25, 0.25, -1}, INFINITY}, {{0.25, 0.25, -1}, 0.5}};
  const softcd_closest_point* closest = nullptr;
  ASSERT_EQ(softcd_probe_closest_points(probe(), points, 2, &closest), SOFTCD_OK);
  EXPECT_EQ(closest[0].body, lower_);
  EXPECT_DOUBLE_EQ(closest[0].distance, 1.0);
  EXPECT_DOUBLE_EQ(closest[0].position[2], 0.0);
  EXPECT_EQ(closest[1].body, SOFTCD_NO_BODY);
  EXPECT_EQ(closest[1].distance, INFINITY);

  const std::uint64_t* begins = nullptr;
  const softcd_overlap* overlaps = nullptr;
  const softcd_sphere spheres[] = {{{9, 9, 9}, 1}, {{0.25, 0.25, 0}, 0.2}};
  ASSERT_EQ(softcd_probe_sphere_overlaps(probe(), spheres, 2, &begins, &overlaps), SOFTCD_OK);
  EXPECT_EQ(begins[1], 0U);
  ASSERT_EQ(begins[2], 2U);
  EXPECT_EQ(overlaps[0].body, lower_);
  EXPECT_EQ(overlaps[1].body, upper_);
  const softcd_box box = {{-1, -1, -1}, {2, 2, 0.05}};
  ASSERT_EQ(softcd_probe_box_overlaps(probe(), &box, 1, &begins, &overlaps), SOFTCD_OK);
  EXPECT_EQ(begins[1], 1U);
  const softcd_oriented_box turned = {{0.5, 0.5, 0}, {2, 2, 0.05}, {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  ASSERT_EQ(softcd_probe_oriented_box_overlaps(probe(), &turned, 1, &begins, &overlaps), SOFTCD_OK);
  EXPECT_EQ(begins[1], 1U);
}

TEST_F(CProbes, what_is_in_a_capsule) {
  const softcd_capsule capsules[] = {{{0.25, 0.25, -1}, {0.25, 0.25, 1}, 0.01}, {{0.9, 0.9, 0}, {2, 2, 0}, 0.6}};
  const std::uint64_t* begins = nullptr;
  const softcd_overlap* overlaps = nullptr;
  ASSERT_EQ(softcd_probe_capsule_overlaps(probe(), capsules, 2, &begins, &overlaps), SOFTCD_OK);
  ASSERT_EQ(begins[1], 2U);
  ASSERT_EQ(begins[2], 3U);
  EXPECT_EQ(overlaps[1].body, upper_);
  EXPECT_EQ(overlaps[2].body, lower_);
}

TEST_F(CProbes, what_is_in_a_hull) {
  const double tetrahedron[] = {0.3, 0.3, 0.05, 0, 0, 1, 1, 0, 1, 0, 1, 1};
  const double point[] = {0.25, 0.25, 0};
  const softcd_hull hulls[] = {{tetrahedron, 4, 0}, {nullptr, 0, 1}, {tetrahedron, 4, 0.06}, {point, 1, 0.05}};
  const std::uint64_t* begins = nullptr;
  const softcd_overlap* overlaps = nullptr;
  ASSERT_EQ(softcd_probe_hull_overlaps(probe(), hulls, 4, &begins, &overlaps), SOFTCD_OK);
  EXPECT_EQ(std::vector<std::uint64_t>(begins, begins + 5), (std::vector<std::uint64_t>{0, 1, 1, 3, 4}));
  EXPECT_EQ(overlaps[0].body, upper_);
  EXPECT_EQ(overlaps[1].body, lower_);
  EXPECT_EQ(overlaps[2].body, upper_);
  EXPECT_EQ(overlaps[3].body, lower_);
}

TEST_F(CProbes, how_far_bodies_are_and_whether_they_intersect) {
  const softcd_body_pair pairs[] = {{upper_, lower_}, {upper_, upper_}};
  const softcd_body_distance* distances = nullptr;
  ASSERT_EQ(softcd_probe_distances(probe(), pairs, 2, &distances), SOFTCD_OK);
  EXPECT_EQ(distances[0].body_a, upper_);
  EXPECT_EQ(distances[0].body_b, lower_);
  EXPECT_FLOAT_EQ(static_cast<float>(distances[0].distance), 0.1F);
  EXPECT_EQ(distances[0].weights_a[0], 1.0F);
  EXPECT_EQ(distances[0].position_b[2], 0.0);
  EXPECT_EQ(distances[1].body_a, SOFTCD_NO_BODY);
  EXPECT_EQ(distances[1].distance, INFINITY);

  std::uint32_t has_intersections = 1;
  ASSERT_EQ(softcd_probe_has_intersections(probe(), nullptr, &has_intersections), SOFTCD_OK);
  EXPECT_EQ(has_intersections, 0U);
  constexpr float kThrough[] = {0.25F, 0.25F, -0.1F, 0.25F, 0.5F, 5, 0.5F, 0.25F, 5};
  const softcd_positions x = positions(kThrough);
  ASSERT_EQ(softcd_scene_set_positions(scene(), upper_, nullptr, &x), SOFTCD_OK);
  ASSERT_EQ(softcd_probe_has_intersections(probe(), &pairs[0], &has_intersections), SOFTCD_OK);
  EXPECT_EQ(has_intersections, 1U);
  const std::uint64_t* begins = nullptr;
  const softcd_intersection* intersections = nullptr;
  ASSERT_EQ(softcd_probe_intersections(probe(), pairs, 2, &begins, &intersections), SOFTCD_OK);
  ASSERT_EQ(begins[1], 1U);
  EXPECT_EQ(begins[2], 1U);
  EXPECT_EQ(intersections[0].body_a, upper_);
  EXPECT_EQ(intersections[0].body_b, lower_);
}

TEST_F(CProbes, what_a_change_would_intersect) {
  constexpr std::uint32_t kRemoved[] = {0};
  constexpr std::uint32_t kAdded[] = {0, 1, 3, 1, 2, 3};
  constexpr double kBelow[] = {0.25, 0.25, -1};  // towards which the upper triangle would pass through the lower one
  const softcd_change changes[] = {{upper_, kRemoved, 1, kAdded, 2, kBelow, 1},
                                   {lower_, kRemoved, 1, nullptr, 0, nullptr, 0}};
  const std::uint64_t* begins = nullptr;
  const softcd_change_intersection* found = nullptr;
  ASSERT_EQ(softcd_probe_intersections_after(probe(), changes, 2, &begins, &found), SOFTCD_OK) << softcd_last_error();
  ASSERT_EQ(begins[1], 2U);
  EXPECT_EQ(begins[2], 2U);
  for (std::uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(found[i].added, i);
    EXPECT_EQ(found[i].body, lower_);
    EXPECT_EQ(found[i].triangle, 0U);
  }
}

TEST_F(CProbes, a_body_filter_leaves_bodies_out) {
  std::vector<softcd_body> asked;
  const softcd_body_filter filter = [](void* data, softcd_body body) {
    static_cast<std::vector<softcd_body>*>(data)->push_back(body);
    return std::uint32_t{body == 0 ? 0U : 4U};
  };
  ASSERT_EQ(softcd_probe_set_body_filter(probe(), filter, &asked), SOFTCD_OK);
  const softcd_point point = {{0.25, 0.25, -1}, INFINITY};
  const softcd_closest_point* closest = nullptr;
  ASSERT_EQ(softcd_probe_closest_points(probe(), &point, 1, &closest), SOFTCD_OK);
  EXPECT_EQ(closest[0].body, upper_);
  EXPECT_EQ(asked, (std::vector<softcd_body>{lower_, upper_}));
  ASSERT_EQ(softcd_probe_set_body_filter(probe(), nullptr, nullptr), SOFTCD_OK);
  ASSERT_EQ(softcd_probe_closest_points(probe(), &point, 1, &closest), SOFTCD_OK);
  EXPECT_EQ(closest[0].body, lower_);
}

TEST_F(CProbes, nothing_may_be_asked) {
  const softcd_ray_hit* hits = nullptr;
  EXPECT_EQ(softcd_probe_first_hits(probe(), nullptr, 0, &hits), SOFTCD_OK);
  const std::uint64_t* begins = nullptr;
  EXPECT_EQ(softcd_probe_all_hits(probe(), nullptr, 0, &begins, &hits), SOFTCD_OK);
  const softcd_intersection* intersections = nullptr;
  EXPECT_EQ(softcd_probe_intersections(probe(), nullptr, 0, &begins, &intersections), SOFTCD_OK);
  const softcd_change_intersection* after = nullptr;
  EXPECT_EQ(softcd_probe_intersections_after(probe(), nullptr, 0, &begins, &after), SOFTCD_OK);
}

}  // namespace
}  // namespace softcd::test
