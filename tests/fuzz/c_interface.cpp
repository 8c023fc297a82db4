#include <array>
#include <vector>

#include "bytes.hpp"
#include "softcd/softcd.h"

// Whatever a function of softcd.h is given, except invalid pointers, it returns one of its codes with a text. Where it
// fails its results are 0.
namespace softcd::test {
namespace {

constexpr int kMostCalls = 40;

class Handles {
 public:
  explicit Handles(Bytes& bytes) : bytes_(bytes) {}
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    for (softcd_query* query : queries_) softcd_query_destroy(query);
    for (softcd_probe* probe : probes_) softcd_probe_destroy(probe);
    for (softcd_scene* scene : scenes_) softcd_scene_destroy(scene);
  }

  void run() {
    create_scene();
    create_query();
    add_body();
    for (int call = 0; call < kMostCalls && !bytes_.empty(); ++call) one_call();
  }

 private:
  void one_call() {
    switch (bytes_.below(18)) {
      case 0:
        return bytes_.one_in(4) ? create_scene() : set_scene_options();
      case 1:
        return create_query();
      case 2:
        return create_probe();
      case 3:
      case 4:
        return add_body();
      case 5:
        return update_body();
      case 6:
        return change_body();
      case 7:
      case 8:
      case 9:
        return set_positions();
      case 10:
        return set_query_options();
      case 11:
        return start();
      case 12:
        return wait();
      case 13:
        return detect();
      case 14:
        return read_out();
      case 15:
        return add_mesh();
      case 16:
        return update_mesh();
      default:
        return ask();
    }
  }

  /// Returns whether the status is SOFTCD_OK; it must be one of the codes.
  bool is_ok(softcd_status status) {
    require(status >= SOFTCD_OK && status <= SOFTCD_OUT_OF_MEMORY, "a status is one of its codes");
    if (status != SOFTCD_OK) require(softcd_last_error()[0] != '\0', "errors have a text");
    return status == SOFTCD_OK;
  }

  /// Checks a list, which must be empty where the call failed.
  template <class T>
  void check_list(bool ok, const T* list, std::uint64_t count) {
    if (!ok) require(list == nullptr && count == 0, "calls that fail have no results");
    if (count > 0) require(list != nullptr, "results are somewhere");
    for (std::uint64_t i = 0; i < count; ++i) last_ = *reinterpret_cast<const unsigned char*>(list + i);
  }

  template <class T, std::size_t N>
  T* some(const std::array<T*, N>& handles) {
    return bytes_.one_in(32) ? nullptr : handles[bytes_.below(N)];
  }

  /// Returns defaults with random bytes in some members, and now and then a size of another version.
  template <class Struct>
  Struct fuzzed(softcd_status (*initialize)(Struct*, std::uint64_t)) {
    Struct value{};
    require(initialize(&value, sizeof value) == SOFTCD_OK, "structs have defaults");
    for (std::uint32_t i = bytes_.below(4); i > 0; --i) {
      const std::uint32_t word = 1 + bytes_.below(sizeof value / 4 - 1);
      const std::uint32_t content = bytes_.one_in(4) ? bytes_.take<std::uint32_t>() : bytes_.below(4);
      std::memcpy(reinterpret_cast<char*>(&value) + 4 * word, &content, 4);
    }
    if (bytes_.one_in(32)) value.struct_size = bytes_.take<std::uint32_t>();
    return value;
  }

  softcd_scene_options fuzzed_scene_options() {
    softcd_scene_options options = fuzzed(softcd_scene_options_init);
    if (options.backend == SOFTCD_BACKEND_AUTOMATIC) options.backend = SOFTCD_BACKEND_CPU;
    options.cuda_stream = nullptr;  // an invalid handle may crash a driver
    return options;
  }

  void create_scene() {
    softcd_scene*& scene = scenes_[bytes_.below(2)];
    softcd_scene_destroy(scene);
    const softcd_scene_options options = fuzzed_scene_options();
    const bool ok = is_ok(softcd_scene_create(bytes_.below(2) == 0 ? nullptr : &options, &scene));
    require(ok == (scene != nullptr), "there is a scene where there is no error");
    softcd_scene_set_log(
        scene, [](void*, softcd_log_level, const char* text) { require(text[0] != '\0', "logs say something"); },
        nullptr);
  }
  void set_scene_options() {
    const softcd_scene_options options = fuzzed_scene_options();
    is_ok(softcd_scene_set_options(some(scenes_), &options));
  }

  void create_query() {
    softcd_query*& query = queries_[bytes_.below(3)];
    softcd_query_destroy(query);
    const softcd_query_options options = fuzzed(softcd_query_options_init);
    const bool ok = is_ok(softcd_query_create(some(scenes_), bytes_.below(2) == 0 ? nullptr : &options, &query));
    require(ok == (query != nullptr), "there is a query where there is no error");
  }
  void create_probe() {
    softcd_probe*& probe = probes_[bytes_.below(2)];
    softcd_probe_destroy(probe);
    const bool ok = is_ok(softcd_probe_create(some(scenes_), bytes_.below(3), &probe));
    require(ok == (probe != nullptr), "there is a probe where there is no error");
  }

  /// Returns random elements of `width` indices.
  std::vector<std::uint32_t> fuzzed_indices(std::uint32_t width) {
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = width * bytes_.below(12); i > 0; --i) indices.push_back(bytes_.below(11));
    return indices;
  }
  std::vector<std::uint32_t> fuzzed_triangles() { return fuzzed_indices(3); }
  /// Returns a count, usually the body's.
  std::uint32_t fuzzed_count() { return bytes_.one_in(32) ? bytes_.take<std::uint32_t>() % 100000 : 12; }
  softcd_body some_body() { return bytes_.one_in(16) ? bytes_.take<std::uint32_t>() : bytes_.below(4); }

  void add_body() {
    const std::vector<std::uint32_t> indices = fuzzed_triangles();
    const softcd_body_settings settings = fuzzed(softcd_body_settings_init);
    softcd_body body = 0;
    const bool ok = is_ok(softcd_scene_add_body(some(scenes_), indices.empty() ? nullptr : indices.data(),
                                                indices.size() / 3, fuzzed_count(), &settings, &body));
    require(ok == (body != SOFTCD_NO_BODY), "there is a body where there is no error");
  }
  void update_body() {
    const std::vector<std::uint32_t> indices = fuzzed_triangles();
    const bool has_none = bytes_.one_in(8);
    is_ok(softcd_scene_update_body(some(scenes_), some_body(), has_none ? nullptr : indices.data(), indices.size() / 3,
                                   fuzzed_count(), nullptr));
  }

  struct FuzzedMesh {
    std::vector<std::uint32_t> triangles, segments;
    softcd_mesh mesh;
  };
  FuzzedMesh fuzzed_mesh() {
    FuzzedMesh given{fuzzed_triangles(), {}, {}};
    if (bytes_.below(2) == 0) given.segments = fuzzed_indices(2);
    given.mesh = {sizeof(softcd_mesh),        fuzzed_count(),        given.triangles.data(),
                  given.triangles.size() / 3, given.segments.data(), given.segments.size() / 2};
    if (bytes_.one_in(16)) given.mesh.triangles = nullptr;
    if (bytes_.one_in(16)) given.mesh.segments = nullptr;
    if (bytes_.one_in(32)) given.mesh.struct_size = bytes_.take<std::uint32_t>();
    return given;
  }
  void add_mesh() {
    const FuzzedMesh given = fuzzed_mesh();
    const softcd_body_settings settings = fuzzed(softcd_body_settings_init);
    softcd_body body = 0;
    const bool ok = is_ok(softcd_scene_add_mesh(some(scenes_), &given.mesh, &settings, &body));
    require(ok == (body != SOFTCD_NO_BODY), "there is a body where there is no error");
  }
  void update_mesh() {
    const FuzzedMesh given = fuzzed_mesh();
    const std::vector<std::uint32_t> changed = fuzzed_indices(1);
    is_ok(softcd_scene_update_mesh(some(scenes_), some_body(), bytes_.one_in(16) ? nullptr : &given.mesh, nullptr,
                                   bytes_.one_in(8) ? nullptr : changed.data(), changed.size()));
  }
  void change_body() {
    softcd_scene* scene = some(scenes_);
    const softcd_body body = some_body();
    if (bytes_.below(2) == 0) {
      const softcd_body_settings settings = fuzzed(softcd_body_settings_init);
      is_ok(softcd_scene_set_settings(scene, body, &settings));
    } else if (is_ok(softcd_scene_remove_body(scene, body))) {
      std::uint32_t has_body = 1;
      require(is_ok(softcd_scene_has_body(scene, body, &has_body)) && has_body == 0, "removed bodies are gone");
    }
  }

  softcd_positions fuzzed_given(const std::vector<double>& memory) {
    softcd_positions x{sizeof x, bytes_.below(2), SOFTCD_HOST, memory.data(), 12, 24, nullptr};
    switch (bytes_.below(24)) {
      case 1:
        x.scalar = bytes_.take<std::uint32_t>();
        break;
      case 2:
        x.memory = bytes_.take<std::uint32_t>();
        break;
      case 3:
        x.data = nullptr;
        break;
      case 4:
        x.count = bytes_.below(12);
        break;
      case 5:
        x.stride = bytes_.below(25);
        break;
      case 6:
        x.struct_size = bytes_.below(64);
        break;
      default:
        break;
    }
    return x;
  }
  void set_positions() {
    for (std::vector<double>& memory : memory_) {
      memory.clear();
      for (int i = 0; i < 36; ++i) memory.push_back(fuzzed_number());
    }
    const softcd_positions x_t0 = fuzzed_given(memory_[0]);
    const softcd_positions x_t1 = fuzzed_given(memory_[1]);
    is_ok(softcd_scene_set_positions(some(scenes_), some_body(), bytes_.below(2) == 0 ? nullptr : &x_t0,
                                     bytes_.one_in(32) ? nullptr : &x_t1));
  }

  void set_query_options() {
    const softcd_query_options options = fuzzed(softcd_query_options_init);
    is_ok(softcd_query_set_options(some(queries_), bytes_.one_in(8) ? nullptr : &options));
  }
  void start() {
    is_ok(softcd_query_start(some(queries_), bytes_.one_in(16) ? bytes_.take<std::uint32_t>() : bytes_.below(2)));
  }
  void wait() {
    const softcd_contact* contacts = nullptr;
    std::uint64_t count = 0;
    softcd_query* query = some(queries_);
    if (bytes_.one_in(8)) {
      softcd_device_contacts on_device{};
      softcd_pending_contacts pending{};
      on_device.struct_size = bytes_.one_in(8) ? bytes_.below(100) : sizeof on_device;
      pending.struct_size = bytes_.one_in(8) ? bytes_.below(100) : sizeof pending;
      require(!is_ok(softcd_query_on_device(query, &pending)), "there is no device");
      require(!is_ok(softcd_query_wait_on_device(query, &on_device)), "there is no device");
    }
    const bool ok = is_ok(softcd_query_wait(query, &contacts, &count));
    check_list(ok, contacts, count);
  }
  void detect() {
    const softcd_contact* contacts = nullptr;
    std::uint64_t count = 0;
    const bool ok = is_ok(softcd_query_detect(some(queries_), bytes_.below(2), &contacts, &count));
    check_list(ok, contacts, count);
  }
  void read_out() {
    softcd_statistics statistics{};
    statistics.struct_size = bytes_.one_in(8) ? bytes_.below(200) : sizeof statistics;
    is_ok(softcd_query_statistics(some(queries_), &statistics));
    softcd_backend backend = SOFTCD_BACKEND_AUTOMATIC;
    if (is_ok(softcd_scene_backend(some(scenes_), &backend))) require(backend == SOFTCD_BACKEND_CPU, "this is the CPU");
    const auto takes_some = [](void*, softcd_body a, softcd_body b) { return static_cast<std::uint32_t>((a + b) % 3); };
    is_ok(softcd_query_set_pair_filter(some(queries_), bytes_.below(2) == 0 ? nullptr : +takes_some, nullptr));
  }

  double fuzzed_number() { return bytes_.one_in(16) ? bytes_.take<double>() : bytes_.take<std::int8_t>() / 16.0; }

  /// Returns questions of any kind whose members are all doubles.
  template <class Question>
  std::vector<Question> fuzzed_questions() {
    std::vector<Question> questions(bytes_.below(4));
    for (Question& question : questions) {
      std::array<double, sizeof(Question) / sizeof(double)> numbers{};
      for (double& number : numbers) number = fuzzed_number();
      std::memcpy(&question, numbers.data(), sizeof question);
    }
    return questions;
  }
  template <class Question, class Answer>
  void ask_for_one(softcd_status (*call)(softcd_probe*, const Question*, std::uint64_t, const Answer**)) {
    const std::vector<Question> questions = fuzzed_questions<Question>();
    const Answer* answers = nullptr;
    const bool ok = is_ok(call(some(probes_), questions.data(), questions.size(), &answers));
    check_list(ok, answers, ok ? questions.size() : 0);
  }
  template <class Question, class Answer>
  void ask_for_all(softcd_status (*call)(softcd_probe*, const Question*, std::uint64_t, const std::uint64_t**,
                                         const Answer**)) {
    const std::vector<Question> questions = fuzzed_questions<Question>();
    const std::uint64_t* begins = nullptr;
    const Answer* answers = nullptr;
    const bool ok = is_ok(call(some(probes_), questions.data(), questions.size(), &begins, &answers));
    check_list(ok, answers, ok && !questions.empty() ? begins[questions.size()] : 0);
  }
  void ask_about_hulls() {
    std::vector<std::vector<double>> points(bytes_.below(4));
    std::vector<softcd_hull> hulls;
    for (std::vector<double>& of_one : points) {
      for (std::uint32_t i = 3 * bytes_.below(8); i > 0; --i) of_one.push_back(fuzzed_number());
      hulls.push_back({of_one.data(), of_one.size() / 3, fuzzed_number()});
      if (bytes_.one_in(32)) hulls.back().points = nullptr;
    }
    const std::uint64_t* begins = nullptr;
    const softcd_overlap* overlaps = nullptr;
    const bool ok = is_ok(softcd_probe_hull_overlaps(some(probes_), hulls.data(), hulls.size(), &begins, &overlaps));
    check_list(ok, overlaps, ok && !hulls.empty() ? begins[hulls.size()] : 0);
  }
  softcd_body body_or_all() { return bytes_.one_in(4) ? SOFTCD_NO_BODY : some_body(); }
  void ask_about_pairs() {
    std::vector<softcd_body_pair> pairs(bytes_.below(4));
    for (softcd_body_pair& pair : pairs) pair = {body_or_all(), body_or_all()};
    softcd_probe* probe = some(probes_);
    const softcd_body_distance* distances = nullptr;
    bool ok = is_ok(softcd_probe_distances(probe, pairs.data(), pairs.size(), &distances));
    check_list(ok, distances, ok ? pairs.size() : 0);
    const std::uint64_t* begins = nullptr;
    const softcd_intersection* intersections = nullptr;
    ok = is_ok(softcd_probe_intersections(probe, pairs.data(), pairs.size(), &begins, &intersections));
    const std::uint64_t count = ok && !pairs.empty() ? begins[pairs.size()] : 0;
    check_list(ok, intersections, count);
    if (!ok || pairs.size() != 1) return;
    std::uint32_t has_some = 2;
    require(is_ok(softcd_probe_has_intersections(probe, pairs.data(), &has_some)), "what was answered is again");
    require(has_some == (count > 0 ? 1 : 0), "there are intersections where some are found");
  }
  void ask_about_changes() {
    struct Fuzzed {
      std::vector<std::uint32_t> removed, added;
      std::vector<double> new_vertices;
    };
    std::vector<Fuzzed> given(bytes_.below(3));
    std::vector<softcd_change> changes;
    for (Fuzzed& change : given) {
      change = {fuzzed_indices(1), fuzzed_triangles(), {}};
      for (std::uint32_t i = 3 * bytes_.below(3); i > 0; --i) change.new_vertices.push_back(fuzzed_number());
      changes.push_back({some_body(), change.removed.data(), change.removed.size(), change.added.data(),
                         change.added.size() / 3, change.new_vertices.data(), change.new_vertices.size() / 3});
      if (bytes_.one_in(32)) changes.back().added = nullptr;
    }
    const std::uint64_t* begins = nullptr;
    const softcd_change_intersection* found = nullptr;
    const bool ok =
        is_ok(softcd_probe_intersections_after(some(probes_), changes.data(), changes.size(), &begins, &found));
    check_list(ok, found, ok && !changes.empty() ? begins[changes.size()] : 0);
  }
  void set_body_filter() {
    const auto takes_some = [](void*, softcd_body body) { return static_cast<std::uint32_t>(body % 3); };
    is_ok(softcd_probe_set_body_filter(some(probes_), bytes_.below(2) == 0 ? nullptr : +takes_some, nullptr));
  }
  void ask() {
    switch (bytes_.below(11)) {
      case 0:
        return ask_for_one(softcd_probe_first_hits);
      case 1:
        return ask_for_all(softcd_probe_all_hits);
      case 2:
        return ask_for_one(softcd_probe_closest_points);
      case 3:
        return ask_for_all(softcd_probe_sphere_overlaps);
      case 4:
        return ask_for_all(softcd_probe_capsule_overlaps);
      case 5:
        return ask_for_all(softcd_probe_oriented_box_overlaps);
      case 6:
        return ask_about_pairs();
      case 7:
        return ask_about_changes();
      case 8:
        return set_body_filter();
      case 9:
        return ask_about_hulls();
      default:
        return ask_for_all(softcd_probe_box_overlaps);
    }
  }

  Bytes& bytes_;
  std::array<softcd_scene*, 2> scenes_{};
  std::array<softcd_query*, 3> queries_{};
  std::array<softcd_probe*, 2> probes_{};
  std::array<std::vector<double>, 2> memory_;  ///< positions that were set
  volatile unsigned char last_ = 0;            ///< so that results are read
};

}  // namespace
}  // namespace softcd::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  softcd::test::Bytes bytes(data, size);
  softcd::test::Handles(bytes).run();
  return 0;
}
