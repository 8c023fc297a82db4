#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "backend_under_test.hpp"
#include "device_memory.hpp"
#include "expectations.hpp"
#include "failing_cuda_calls.hpp"
#include "mesh_generators.hpp"

// Lets each call of the CUDA runtime fail, once or for good. The result must be the same bytes, or an error and a scene
// that can still be used.
namespace softcd::test {
namespace {

SceneBody soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 300;
  options.half_extent = 1.5;
  options.largest = 1.0;
  options.size_ratio = 8.0;
  options.joined_share = 0.5;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.3, seed), everything(0.03F));
}

/// Positions on the device.
template <class T>
struct GivenEnd {
  explicit GivenEnd(const std::vector<Vec3<T>>& x) : count(x.size()), memory(Backend::cuda, count * sizeof(Vec3<T>)) {
    memory.write(x.data(), count * sizeof(Vec3<T>));
  }
  Positions get() { return Positions::on_device(reinterpret_cast<const T*>(memory.data()), count, sizeof(Vec3<T>)); }

  std::size_t count;
  DeviceMemory memory;
};

std::vector<Vec3f> as_floats(const Positions3& x) {
  std::vector<Vec3f> floats;
  for (const Vec3d& position : x) floats.push_back(vec3_cast<float>(position));
  return floats;
}

/// Both ends of a body's step, as doubles and as floats, on the device, and floats on the host.
struct GivenEnds {
  explicit GivenEnds(const SceneBody& body)
      : t0(body.x_t0),
        t1(body.x_t1),
        host_float_t0(as_floats(body.x_t0)),
        host_float_t1(as_floats(body.x_t1)),
        float_t0(host_float_t0),
        float_t1(host_float_t1) {}

  GivenEnd<double> t0, t1;
  std::vector<Vec3f> host_float_t0, host_float_t1;
  GivenEnd<float> float_t0, float_t1;
};

/// The results of a life's calls, one after another.
struct Lived {
  std::vector<std::vector<Contact>> contacts;
  std::vector<std::vector<std::uint32_t>> answers;  ///< triangles in the results of probes
};

void expect_same(const Lived& expected, const Lived& found) {
  ASSERT_EQ(expected.contacts.size(), found.contacts.size());
  for (std::size_t i = 0; i < expected.contacts.size(); ++i) {
    EXPECT_TRUE(identical(expected.contacts[i], found.contacts[i])) << "detection " << i;
  }
  EXPECT_EQ(expected.answers, found.answers);
}

/// The parts of a life, apart from making a scene of two bodies. They are tested one by one: each call of a life fails
/// in turn, so a life of all parts would take quadratic time.
enum class Part { detections, predicted, questions };

/// A user's calls of a scene, from its making to its end.
class Life {
 public:
  /// Repeats a call that throws because of `failing`, after `failing` has ended.
  Life(Backend backend, std::vector<SceneBody>& bodies, std::vector<GivenEnds>& on_device, FailingCudaCall* failing)
      : backend_(backend), bodies_(bodies), on_device_(on_device), failing_(failing) {}

  Lived live(Part part) {
    SceneOptions options;
    options.backend = backend_;
    attempt([&] { scene_.emplace(options); });
    has_device_ = scene_->backend() == Backend::cuda;
    attempt([&] { query_.emplace(*scene_, query_options()); });
    for (std::size_t b = 0; b < 2; ++b) attempt([&] { ids_.push_back(scene_->add_body(desc_of(b))); });
    for (std::size_t b = 0; b < 2; ++b)
      attempt([&] { scene_->set_positions(ids_[b], bodies_[b].x_t0, bodies_[b].x_t1); });
    switch (part) {
      case Part::detections:
        detect_on_both_sides();
        break;
      case Part::predicted:
        detect_predicted();
        break;
      case Part::questions:
        ask();
        break;
    }
    return std::move(lived_);
  }

 private:
  static QueryOptions query_options() {
    QueryOptions options;
    options.detection = Detection::ccd;
    return options;
  }
  BodyDesc desc_of(std::size_t body) const {
    return {bodies_[body].triangles, static_cast<std::uint32_t>(bodies_[body].x_t0.size()), bodies_[body].settings};
  }

  /// Calls f. With `needs_device` the CPU cannot take over.
  template <class F>
  void attempt(const F& f, bool needs_device = false) {
    std::string problem;
    try {
      return f();
    } catch (const BackendError& error) {
      problem = error.what();
    } catch (const OutOfMemory& error) {
      problem = error.what();
    }
    EXPECT_TRUE(backend_ == Backend::cuda || needs_device) << problem;
    EXPECT_TRUE(failing_ != nullptr && failing_->has_failed()) << problem;
    if (failing_ != nullptr) failing_->end();
    f();
  }

  void detect_on_both_sides() {
    for (int times = 0; times < 3; ++times) detect(false);  // by itself, captured, replayed
    attempt([&] { scene_->update_body(ids_[0], desc_of(2)); });
    set_other_positions();
    for (int times = 0; times < 2; ++times) detect(true);
  }

  void detect_predicted() {
    attempt([&] { scene_->update_body(ids_[0], desc_of(2)); });
    for (int times = 0; times < 4; ++times) {  // the last two without looking first
      set_floats();
      detect(true);
    }
    if (backend_ == Backend::cuda) detect_on_device();
  }

  /// Sets positions on the device, unless the scene found none when it was made.
  void set_other_positions() {
    for (std::size_t b = 0; b < 2; ++b) {
      const SceneBody& body = bodies_[b == 0 ? 2 : 1];
      GivenEnds& x = on_device_[b];
      attempt(
          [&] {
            if (has_device_) {
              scene_->set_positions(ids_[b], x.t0.get(), x.t1.get());
            } else {
              scene_->set_positions(ids_[b], body.x_t0, body.x_t1);
            }
          },
          has_device_);
    }
  }

  /// Sets the same positions as floats.
  void set_floats() {
    for (std::size_t b = 0; b < 2; ++b) {
      GivenEnds& x = on_device_[b];
      attempt(
          [&] {
            if (has_device_) {
              scene_->set_positions(ids_[b], x.float_t0.get(), x.float_t1.get());
            } else {
              scene_->set_positions(ids_[b], x.host_float_t0, x.host_float_t1);
            }
          },
          has_device_);
    }
  }

  /// Detects. `are_there` says whether positions are on the device.
  void detect(bool are_there) {
    attempt(
        [&] {
          const Span<const Contact> contacts = query_->detect();
          lived_.contacts.emplace_back(contacts.begin(), contacts.end());
        },
        are_there);
  }

  void detect_on_device() {
    QueryOptions options = query_options();
    options.contacts_on_device = true;
    attempt([&] { query_->set_options(options); });
    DeviceContacts found;
    attempt([&] { found = query_->detect_on_device(); });
    const std::vector<std::byte> bytes = read_device(Backend::cuda, found.data, found.count * sizeof(Contact));
    const auto* const contacts = reinterpret_cast<const Contact*>(bytes.data());
    EXPECT_TRUE(identical(lived_.contacts.back(), {contacts, found.count}));
  }

  /// Asks a probe, and records the triangles of its results.
  template <class Ask>
  void ask(const Ask& question) {
    attempt(
        [&] {
          std::vector<std::uint32_t> triangles;
          question(triangles);
          lived_.answers.push_back(std::move(triangles));
        },
        true);
  }
  template <class Answers>
  static void append_lists(const Answers& lists, std::vector<std::uint32_t>& triangles) {
    for (const auto& answer : lists.all()) triangles.push_back(answer.triangle);
  }

  void ask() {
    std::optional<Probe> probe;
    attempt([&] { probe.emplace(*scene_); });
    const std::vector<ProbePoint> points = {{{0, 0, 0}}, {{1, -0.5, 0.3}}, {{-3, 2, 1}}};
    const std::vector<Ray> rays = {{{-5, 0.1, 0.2}, {1, 0, 0}}, {{0.3, 5, -0.4}, {0, -1, 0.1}}};
    const std::vector<ProbeSphere> spheres = {{{0, 0, 0}, 0.7}, {{1, 1, 0}, 0.2}};
    const std::vector<ProbeBox> boxes = {{{-0.5, -0.5, -0.5}, {0.5, 0.4, 0.3}}};
    const std::vector<ProbeOrientedBox> turned = {
        {{0.2, 0, 0.1}, {0.4, 0.3, 0.2}, {{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}}};
    const std::vector<Vec3d> corners = {{0, 0, 0}, {0.6, 0, 0.1}, {0, 0.5, 0.2}, {0.1, 0.2, 0.7}};
    const std::vector<ProbeHull> hulls = {{corners, 0.1}, {corners}};
    ask([&](auto& triangles) {
      for (const ClosestPoint& nearest : probe->closest_points(points)) triangles.push_back(nearest.triangle);
    });
    ask([&](auto& triangles) {
      for (const RayHit& hit : probe->first_hits(rays)) triangles.push_back(hit.triangle);
    });
    ask([&](auto& triangles) { append_lists(probe->all_hits(rays), triangles); });
    ask([&](auto& triangles) { append_lists(probe->overlaps(spheres), triangles); });
    ask([&](auto& triangles) { append_lists(probe->overlaps(boxes), triangles); });
    ask([&](auto& triangles) { append_lists(probe->overlaps(turned), triangles); });
    ask([&](auto& triangles) { append_lists(probe->overlaps(hulls), triangles); });
  }

  Backend backend_;
  std::vector<SceneBody>& bodies_;
  std::vector<GivenEnds>& on_device_;
  FailingCudaCall* failing_;
  std::optional<softcd::Scene> scene_;
  std::optional<Query> query_;
  bool has_device_ = false;
  std::vector<BodyId> ids_;
  Lived lived_;
};

class FailedCudaCalls : public testing::TestWithParam<std::tuple<Backend, Part>> {
 protected:
  void SetUp() override {
    const std::string reason = why_missing(Backend::cuda);
    if (!reason.empty()) GTEST_SKIP() << reason;
  }

  /// Returns the positions of the body that replaces the first one, and of the second one.
  std::vector<GivenEnds> given() {
    std::vector<GivenEnds> ends;
    for (const std::size_t b : {2U, 1U}) ends.emplace_back(bodies_[b]);
    return ends;
  }
  Lived live(Backend backend) {
    std::vector<GivenEnds> on_device = given();
    return Life(backend, bodies_, on_device, nullptr).live(part_);
  }

  /// Lets each call in turn fail, until a life makes fewer calls.
  void fail_each(Fails fails) {
    const Lived expected = live(Backend::cpu);
    ASSERT_TRUE(part_ == Part::questions || expected.contacts.at(0).size() > 100);
    expect_same(expected, live(backend_));
    const std::int64_t living = living_cuda_objects();
    bool has_failed = true;
    std::uint64_t n = 0;
    while (has_failed && !HasFailure()) {
      SCOPED_TRACE(testing::Message() << "call " << ++n);
      Lived found;
      {
        std::vector<GivenEnds> on_device = given();
        FailingCudaCall failing(n, fails);
        found = Life(backend_, bodies_, on_device, &failing).live(part_);
        has_failed = failing.has_failed();
      }
      expect_same(expected, found);
      EXPECT_EQ(living_cuda_objects(), living);
    }
    EXPECT_GT(n, 100U);
    RecordProperty("calls", std::to_string(n - 1));
  }

  Backend backend_ = std::get<Backend>(GetParam());
  Part part_ = std::get<Part>(GetParam());
  std::vector<SceneBody> bodies_ = {soup(1), soup(2), soup(3)};
};

TEST_P(FailedCudaCalls, one_at_a_time) {
  fail_each(Fails::once);
}
TEST_P(FailedCudaCalls, one_and_all_after_it) {
  fail_each(Fails::from_then_on);
}

std::string name_of(const testing::TestParamInfo<std::tuple<Backend, Part>>& life) {
  const auto [backend, part] = life.param;
  const std::array<const char*, 3> parts = {"detections", "predicted", "questions"};
  return std::string(backend == Backend::cuda ? "cuda_" : "automatic_") + parts.at(static_cast<std::size_t>(part));
}

INSTANTIATE_TEST_SUITE_P(Lives, FailedCudaCalls,
                         testing::Combine(testing::Values(Backend::cuda, Backend::automatic),
                                          testing::Values(Part::detections, Part::predicted, Part::questions)),
                         name_of);

}  // namespace
}  // namespace softcd::test
