#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "handles.hpp"

// Whatever the arguments, a function returns an error code, its text names the argument, and the scene is unchanged.
namespace softcd::test {
namespace {

class CErrors : public TwoTriangles {
 protected:
  void TearDown() override { EXPECT_EQ(detect(), 1U) << "something has changed"; }

  static void expect_refused(softcd_status status, const std::string& part_of_text) {
    EXPECT_EQ(status, SOFTCD_INVALID_INPUT) << part_of_text;
    EXPECT_NE(std::string(softcd_last_error()).find(part_of_text), std::string::npos) << softcd_last_error();
  }
};

TEST_F(CErrors, null_scenes_and_arguments) {
  softcd_body body = 7;
  std::uint32_t number = 7;
  softcd_scene* none = nullptr;
  const softcd_positions x = positions(kLower);
  expect_refused(softcd_scene_create(nullptr, nullptr), "scene is NULL");
  expect_refused(softcd_scene_set_options(none, nullptr), "scene is NULL");
  expect_refused(softcd_scene_backend(none, &number), "scene is NULL");
  expect_refused(softcd_scene_backend(scene(), nullptr), "backend is NULL");
  expect_refused(softcd_scene_set_log(none, nullptr, nullptr), "scene is NULL");
  expect_refused(softcd_scene_add_body(none, kTriangle, 1, 3, nullptr, &body), "scene is NULL");
  EXPECT_EQ(body, SOFTCD_NO_BODY);
  expect_refused(softcd_scene_add_body(scene(), kTriangle, 1, 3, nullptr, nullptr), "body is NULL");
  expect_refused(softcd_scene_add_body(scene(), nullptr, 1, 3, nullptr, &body), "triangles is NULL");
  expect_refused(softcd_scene_update_body(none, 0, kTriangle, 1, 3, nullptr), "scene is NULL");
  softcd_mesh mesh = {sizeof mesh, 3, kTriangle, 1, nullptr, 0};
  expect_refused(softcd_scene_add_mesh(none, &mesh, nullptr, &body), "scene is NULL");
  expect_refused(softcd_scene_add_mesh(scene(), nullptr, nullptr, &body), "mesh is NULL");
  EXPECT_EQ(body, SOFTCD_NO_BODY);
  expect_refused(softcd_scene_add_mesh(scene(), &mesh, nullptr, nullptr), "body is NULL");
  expect_refused(softcd_scene_update_mesh(none, lower_, &mesh, nullptr, nullptr, 0), "scene is NULL");
  expect_refused(softcd_scene_update_mesh(scene(), lower_, nullptr, nullptr, nullptr, 0), "mesh is NULL");
  expect_refused(softcd_scene_update_mesh(scene(), lower_, &mesh, nullptr, nullptr, 1), "changed is NULL");
  mesh.segment_count = 1;
  expect_refused(softcd_scene_update_mesh(scene(), lower_, &mesh, nullptr, nullptr, 0), "segments is NULL");
  mesh.triangles = nullptr;
  expect_refused(softcd_scene_add_mesh(scene(), &mesh, nullptr, &body), "triangles is NULL");
  expect_refused(softcd_scene_set_settings(none, 0, nullptr), "scene is NULL");
  expect_refused(softcd_scene_remove_body(none, 0), "scene is NULL");
  expect_refused(softcd_scene_has_body(none, 0, &number), "scene is NULL");
  expect_refused(softcd_scene_has_body(scene(), 0, nullptr), "has_body is NULL");
  expect_refused(softcd_scene_set_positions(none, 0, nullptr, &x), "scene is NULL");
  expect_refused(softcd_scene_set_positions(scene(), lower_, &x, nullptr), "x_t1 is NULL");
  softcd_scene_destroy(nullptr);
}

TEST_F(CErrors, null_queries_and_arguments) {
  softcd_query* none = nullptr;
  softcd_query* created = query();
  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 7;
  softcd_statistics statistics{};
  statistics.struct_size = sizeof statistics;
  expect_refused(softcd_query_create(nullptr, nullptr, &created), "scene is NULL");
  EXPECT_EQ(created, nullptr);
  expect_refused(softcd_query_create(scene(), nullptr, nullptr), "query is NULL");
  expect_refused(softcd_query_set_options(none, nullptr), "query is NULL");
  expect_refused(softcd_query_set_pair_filter(none, nullptr, nullptr), "query is NULL");
  expect_refused(softcd_query_start(none, SOFTCD_PAIRS_ALL), "query is NULL");
  expect_refused(softcd_query_wait(none, &contacts, &count), "query is NULL");
  EXPECT_EQ(count, 0U);
  expect_refused(softcd_query_wait(query(), nullptr, &count), "contacts is NULL");
  softcd_device_contacts found{};
  softcd_pending_contacts pending{};
  found.struct_size = sizeof found;
  pending.struct_size = sizeof pending;
  found.count = pending.capacity = 7;
  expect_refused(softcd_query_wait_on_device(none, &found), "query is NULL");
  expect_refused(softcd_query_on_device(none, &pending), "query is NULL");
  EXPECT_EQ(found.count, 0U);
  EXPECT_EQ(found.struct_size, sizeof found);
  EXPECT_EQ(pending.capacity, 0U);
  expect_refused(softcd_query_wait_on_device(query(), nullptr), "contacts is NULL");
  expect_refused(softcd_query_on_device(query(), nullptr), "contacts is NULL");
  expect_refused(softcd_query_detect(none, SOFTCD_PAIRS_ALL, &contacts, &count), "query is NULL");
  expect_refused(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, nullptr), "count is NULL");
  expect_refused(softcd_query_statistics(none, &statistics), "query is NULL");
  expect_refused(softcd_query_statistics(query(), nullptr), "statistics is NULL");
  softcd_query_destroy(nullptr);
}

TEST_F(CErrors, null_probes_and_arguments) {
  softcd_probe* none = nullptr;
  softcd_probe* created = nullptr;
  const softcd_ray_hit* hits = nullptr;
  const softcd_closest_point* closest = nullptr;
  const softcd_overlap* overlaps = nullptr;
  const std::uint64_t* begins = nullptr;
  expect_refused(softcd_probe_create(nullptr, SOFTCD_T1, &created), "scene is NULL");
  expect_refused(softcd_probe_create(scene(), SOFTCD_T1, nullptr), "probe is NULL");
  expect_refused(softcd_probe_create(scene(), 2, &created), "step_end is 2");
  expect_refused(softcd_probe_first_hits(none, nullptr, 0, &hits), "probe is NULL");
  expect_refused(softcd_probe_all_hits(none, nullptr, 0, &begins, &hits), "probe is NULL");
  expect_refused(softcd_probe_closest_points(none, nullptr, 0, &closest), "probe is NULL");
  expect_refused(softcd_probe_sphere_overlaps(none, nullptr, 0, &begins, &overlaps), "probe is NULL");
  expect_refused(softcd_probe_box_overlaps(none, nullptr, 0, &begins, &overlaps), "probe is NULL");
  ASSERT_EQ(softcd_probe_create(scene(), SOFTCD_T1, &created), SOFTCD_OK);
  const ProbePointer probe(created);
  expect_refused(softcd_probe_first_hits(created, nullptr, 1, &hits), "rays is NULL");
  expect_refused(softcd_probe_all_hits(created, nullptr, 0, nullptr, &hits), "begins is NULL");
  expect_refused(softcd_probe_closest_points(created, nullptr, 1, &closest), "points is NULL");
  expect_refused(softcd_probe_sphere_overlaps(created, nullptr, 1, &begins, &overlaps), "spheres is NULL");
  expect_refused(softcd_probe_box_overlaps(created, nullptr, 1, &begins, &overlaps), "boxes is NULL");
  expect_refused(softcd_probe_oriented_box_overlaps(created, nullptr, 1, &begins, &overlaps), "boxes is NULL");
  expect_refused(softcd_probe_capsule_overlaps(created, nullptr, 1, &begins, &overlaps), "capsules is NULL");
  expect_refused(softcd_probe_hull_overlaps(created, nullptr, 1, &begins, &overlaps), "hulls is NULL");
  const double point[] = {0, 0, 0};
  const softcd_hull without_points[] = {{point, 1, 0}, {nullptr, 1, 0}};
  const softcd_hull too_many_points = {point, std::uint64_t{1} << 31, 0};
  expect_refused(softcd_probe_hull_overlaps(none, without_points, 1, &begins, &overlaps), "probe is NULL");
  expect_refused(softcd_probe_hull_overlaps(created, without_points, 2, &begins, &overlaps), "points is NULL");
  expect_refused(softcd_probe_hull_overlaps(created, &too_many_points, 1, &begins, &overlaps), "2^31");
  softcd_probe_destroy(nullptr);
}

TEST_F(CErrors, questions_about_bodies_that_cannot_be_answered) {
  softcd_probe* none = nullptr;
  softcd_probe* created = nullptr;
  ASSERT_EQ(softcd_probe_create(scene(), SOFTCD_T1, &created), SOFTCD_OK);
  const ProbePointer probe(created);
  const softcd_body_pair pairs[] = {{upper_, lower_}, {99, lower_}};
  const softcd_body_distance* distances = nullptr;
  const softcd_intersection* intersections = nullptr;
  const softcd_change_intersection* after = nullptr;
  const std::uint64_t* begins = nullptr;
  std::uint32_t has_intersections = 7;
  expect_refused(softcd_probe_set_body_filter(none, nullptr, nullptr), "probe is NULL");
  expect_refused(softcd_probe_distances(none, pairs, 1, &distances), "probe is NULL");
  expect_refused(softcd_probe_distances(created, nullptr, 1, &distances), "pairs is NULL");
  expect_refused(softcd_probe_distances(created, pairs, 2, &distances), "pair 1: body 99 is not in the scene");
  expect_refused(softcd_probe_intersections(created, nullptr, 1, &begins, &intersections), "pairs is NULL");
  expect_refused(softcd_probe_intersections(created, pairs, 2, &begins, &intersections), "pair 1: body 99");
  expect_refused(softcd_probe_has_intersections(none, nullptr, &has_intersections), "probe is NULL");
  EXPECT_EQ(has_intersections, 0U);
  expect_refused(softcd_probe_has_intersections(created, nullptr, nullptr), "has_intersections is NULL");
  expect_refused(softcd_probe_has_intersections(created, &pairs[1], &has_intersections), "body 99");

  expect_refused(softcd_probe_intersections_after(created, nullptr, 1, &begins, &after), "changes is NULL");
  softcd_change change = {upper_, nullptr, 1, nullptr, 0, nullptr, 0};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "removed is NULL");
  change = {upper_, nullptr, 0, nullptr, 1, nullptr, 0};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "added is NULL");
  change = {upper_, nullptr, 0, nullptr, 0, nullptr, 1};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "new_vertices is NULL");
  constexpr std::uint32_t kIndices[] = {0, 1, 3};
  change = {upper_, kIndices, 2, nullptr, 0, nullptr, 0};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "change 0");
  change = {upper_, nullptr, 0, kIndices, 1, nullptr, 0};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "change 0");
  change = {99, nullptr, 0, nullptr, 0, nullptr, 0};
  expect_refused(softcd_probe_intersections_after(created, &change, 1, &begins, &after), "change 0: body 99");
}

TEST_F(CErrors, structs_of_other_sizes) {
  softcd_scene_options scene_options{};
  softcd_body_settings settings{};
  softcd_query_options query_options{};
  softcd_statistics statistics{};
  softcd_device_contacts on_device{};
  softcd_pending_contacts pending{};
  softcd_positions x = positions(kLower);
  x.struct_size -= 1;
  softcd_body body = 0;
  softcd_scene* other_scene = nullptr;
  softcd_query* other_query = nullptr;
  const std::string of_size_0 = "struct_size is 0 bytes";
  expect_refused(softcd_scene_options_init(&scene_options, sizeof scene_options + 8), "options");
  expect_refused(softcd_body_settings_init(&settings, 0), of_size_0);
  expect_refused(softcd_query_options_init(&query_options, 4), "struct_size is 4 bytes");
  expect_refused(softcd_query_options_init(nullptr, sizeof query_options), "options is NULL");
  EXPECT_EQ(query_options.struct_size, 0U);
  expect_refused(softcd_scene_create(&scene_options, &other_scene), of_size_0);
  expect_refused(softcd_scene_set_options(scene(), &scene_options), of_size_0);
  expect_refused(softcd_scene_add_body(scene(), kTriangle, 1, 3, &settings, &body), of_size_0);
  expect_refused(softcd_scene_update_body(scene(), lower_, kTriangle, 1, 3, &settings), of_size_0);
  expect_refused(softcd_scene_set_settings(scene(), lower_, &settings), of_size_0);
  const softcd_mesh mesh = {0, 3, kTriangle, 1, nullptr, 0};
  expect_refused(softcd_scene_add_mesh(scene(), &mesh, nullptr, &body), of_size_0);
  expect_refused(softcd_scene_update_mesh(scene(), lower_, &mesh, nullptr, nullptr, 0), of_size_0);
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "x_t1");
  expect_refused(softcd_query_create(scene(), &query_options, &other_query), of_size_0);
  expect_refused(softcd_query_set_options(query(), &query_options), of_size_0);
  expect_refused(softcd_query_statistics(query(), &statistics), of_size_0);
  expect_refused(softcd_query_wait_on_device(query(), &on_device), of_size_0);
  expect_refused(softcd_query_on_device(query(), &pending), of_size_0);
}

TEST_F(CErrors, values_out_of_range) {
  softcd_scene_options scene_options{};
  ASSERT_EQ(softcd_scene_options_init(&scene_options, sizeof scene_options), SOFTCD_OK);
  scene_options.backend = 3;
  expect_refused(softcd_scene_set_options(scene(), &scene_options), "backend is 3");
  for (const auto option :
       {&softcd_query_options::detection, &softcd_query_options::accuracy, &softcd_query_options::broad_phase,
        &softcd_query_options::contact_rule, &softcd_query_options::step_end}) {
    softcd_query_options options{};
    ASSERT_EQ(softcd_query_options_init(&options, sizeof options), SOFTCD_OK);
    options.*option = 0xFFFFFFFFU;
    expect_refused(softcd_query_set_options(query(), &options), "is 4294967295, which is none of its values");
  }
  expect_refused(softcd_query_start(query(), 2), "pairs is 2");
  softcd_positions x = positions(kLower);
  x.scalar = 2;
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "scalar is 2");
  x = positions(kLower);
  x.memory = 2;
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "memory is 2");
  settings_.margin = std::numeric_limits<float>::quiet_NaN();
  expect_refused(softcd_scene_set_settings(scene(), lower_, &settings_), "margin is nan");
}

TEST_F(CErrors, meshes_and_positions_that_do_not_fit) {
  constexpr std::uint32_t kOutOfRange[] = {0, 1, 3};
  softcd_body body = 0;
  expect_refused(softcd_scene_add_body(scene(), kOutOfRange, 1, 3, nullptr, &body), "vertex index 3");
  EXPECT_EQ(body, SOFTCD_NO_BODY);
  expect_refused(softcd_scene_update_body(scene(), lower_, kOutOfRange, 1, 3, nullptr), "vertex index 3");
  const softcd_mesh mesh = {sizeof mesh, 3, kTriangle, 1, kOutOfRange + 1, 1};
  expect_refused(softcd_scene_add_mesh(scene(), &mesh, nullptr, &body), "segment 0 has vertex index 3");
  EXPECT_EQ(body, SOFTCD_NO_BODY);
  const softcd_mesh whole = {sizeof whole, 3, kTriangle, 1, nullptr, 0};
  expect_refused(softcd_scene_update_mesh(scene(), lower_, &whole, nullptr, kOutOfRange, 2),
                 "triangle 1 is said to have changed");
  const softcd_mesh smaller = {sizeof smaller, 2, kTriangle, 1, nullptr, 0};
  expect_refused(softcd_scene_update_mesh(scene(), lower_, &smaller, nullptr, kTriangle, 0),
                 "triangle 0 has not changed, and has vertex index 2");
  expect_refused(softcd_scene_remove_body(scene(), 99), "body 99 is not in the scene");
  softcd_positions x = positions(kLower);
  expect_refused(softcd_scene_set_positions(scene(), 99, nullptr, &x), "body 99");
  x.count = 2;
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "2 positions were given for t1");
  const softcd_positions end = positions(kLower);
  expect_refused(softcd_scene_set_positions(scene(), lower_, &x, &end), "2 positions were given for t0");
  x = positions(kLower);
  x.stride = 8;
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "stride");
  x = positions(nullptr);
  expect_refused(softcd_scene_set_positions(scene(), lower_, nullptr, &x), "null");
  const softcd_positions floats = positions(kLower);
  const double doubles[9] = {};
  x = {sizeof x, SOFTCD_FLOAT64, SOFTCD_HOST, doubles, 3, 24, nullptr};
  expect_refused(softcd_scene_set_positions(scene(), lower_, &floats, &x), "different types");
}

TEST_F(CErrors, detections_that_nobody_started) {
  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 7;
  softcd_device_contacts on_device{};
  softcd_pending_contacts pending{};
  on_device.struct_size = sizeof on_device;
  pending.struct_size = sizeof pending;
  EXPECT_EQ(softcd_query_on_device(query(), &pending), SOFTCD_ERROR);
  EXPECT_EQ(softcd_query_wait(query(), &contacts, &count), SOFTCD_ERROR);
  EXPECT_EQ(count, 0U);
  EXPECT_STREQ(softcd_last_error(), "no detection was started; call softcd_query_start() first.");
  ASSERT_EQ(softcd_query_start(query(), SOFTCD_PAIRS_ALL), SOFTCD_OK);
  EXPECT_EQ(softcd_query_wait_on_device(query(), &on_device), SOFTCD_ERROR);
  EXPECT_EQ(softcd_query_on_device(query(), &pending), SOFTCD_ERROR) << "contacts are on the host";
  EXPECT_EQ(softcd_query_wait(query(), &contacts, &count), SOFTCD_OK) << softcd_last_error();
  EXPECT_EQ(count, 1U);
  EXPECT_EQ(softcd_query_wait(query(), &contacts, &count), SOFTCD_ERROR);
}

TEST_F(CErrors, a_device_that_cannot_be_had) {
  if (backend_under_test() == Backend::cuda) GTEST_SKIP() << "there may be one";
  softcd_scene_options options{};
  ASSERT_EQ(softcd_scene_options_init(&options, sizeof options), SOFTCD_OK);
  options.backend = SOFTCD_BACKEND_CUDA;
  options.cuda_device = 1000;
  softcd_scene* created = scene();
  EXPECT_EQ(softcd_scene_create(&options, &created), SOFTCD_BACKEND_ERROR);
  EXPECT_EQ(created, nullptr);
  EXPECT_STRNE(softcd_last_error(), "");
  softcd_positions x = positions(kLower);
  x.memory = SOFTCD_CUDA_DEVICE;
  EXPECT_EQ(softcd_scene_set_positions(scene(), lower_, nullptr, &x), SOFTCD_BACKEND_ERROR);
}

TEST_F(CErrors, a_limit_that_does_not_suffice) {
  softcd_scene_options options{};
  ASSERT_EQ(softcd_scene_options_init(&options, sizeof options), SOFTCD_OK);
  options.backend = static_cast<softcd_backend>(backend_under_test());
  options.memory_limit = 1;
  ASSERT_EQ(softcd_scene_set_options(scene(), &options), SOFTCD_OK);
  const softcd_contact* contacts = nullptr;
  std::uint64_t count = 7;
  EXPECT_EQ(softcd_query_detect(query(), SOFTCD_PAIRS_ALL, &contacts, &count), SOFTCD_OUT_OF_MEMORY);
  EXPECT_EQ(count, 0U);
  options.memory_limit = 0;
  ASSERT_EQ(softcd_scene_set_options(scene(), &options), SOFTCD_OK);
}

TEST_F(CErrors, a_scene_that_is_gone) {
  softcd_scene* other = nullptr;
  ASSERT_EQ(softcd_scene_create(nullptr, &other), SOFTCD_OK);
  softcd_query* left_query = nullptr;
  softcd_probe* left_probe = nullptr;
  ASSERT_EQ(softcd_query_create(other, nullptr, &left_query), SOFTCD_OK);
  ASSERT_EQ(softcd_probe_create(other, SOFTCD_T1, &left_probe), SOFTCD_OK);
  ASSERT_EQ(softcd_query_start(left_query, SOFTCD_PAIRS_ALL), SOFTCD_OK);
  softcd_scene_destroy(other);
  const QueryPointer query(left_query);
  const ProbePointer probe(left_probe);
  const softcd_ray ray = {};
  const softcd_ray_hit* hits = nullptr;
  EXPECT_EQ(softcd_query_start(left_query, SOFTCD_PAIRS_ALL), SOFTCD_ERROR);
  EXPECT_EQ(softcd_probe_first_hits(left_probe, &ray, 1, &hits), SOFTCD_ERROR);
  std::uint32_t has_intersections = 7;
  EXPECT_EQ(softcd_probe_has_intersections(left_probe, nullptr, &has_intersections), SOFTCD_ERROR);
  EXPECT_EQ(has_intersections, 0U);
}

// Callbacks must not throw, but even if one does, no exception leaves C.
TEST_F(CErrors, a_callback_that_throws) {
  const softcd_pair_filter filter = [](void*, softcd_body, softcd_body) -> std::uint32_t { throw 3; };
  ASSERT_EQ(softcd_query_set_pair_filter(query(), filter, nullptr), SOFTCD_OK);
  EXPECT_EQ(softcd_query_start(query(), SOFTCD_PAIRS_ALL), SOFTCD_ERROR);
  EXPECT_STRNE(softcd_last_error(), "");
  ASSERT_EQ(softcd_query_set_pair_filter(query(), nullptr, nullptr), SOFTCD_OK);
}

TEST_F(CErrors, a_long_text_ends_with_a_whole_character) {
  const softcd_pair_filter filter = [](void* beginning, softcd_body, softcd_body) -> std::uint32_t {
    std::string text = static_cast<const char*>(beginning);
    for (int i = 0; i < 1000; ++i) text += "\u00e9";  // two bytes
    throw std::runtime_error(text);
  };
  for (char beginning[2] = {'x', '\0'}; const std::size_t length : {1023U, 1022U}) {
    ASSERT_EQ(softcd_query_set_pair_filter(query(), filter, beginning), SOFTCD_OK);
    EXPECT_EQ(softcd_query_start(query(), SOFTCD_PAIRS_ALL), SOFTCD_ERROR);
    EXPECT_EQ(std::strlen(softcd_last_error()), length);
    beginning[0] = '\0';
  }
  ASSERT_EQ(softcd_query_set_pair_filter(query(), nullptr, nullptr), SOFTCD_OK);
}

TEST_F(CErrors, each_thread_has_its_own_text) {
  expect_refused(softcd_scene_remove_body(scene(), 99), "body 99");
  std::string text = "unset";
  std::thread([&] { text = softcd_last_error(); }).join();
  EXPECT_EQ(text, "");
  EXPECT_EQ(detect(), 1U);
  expect_refused(SOFTCD_INVALID_INPUT, "body 99");
}

}  // namespace
}  // namespace softcd::test
