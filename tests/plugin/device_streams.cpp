#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "backend_under_test.hpp"
#include "device_memory.hpp"
#include "expectations.hpp"
#include "failing_cuda_calls.hpp"
#include "mesh_generators.hpp"

// A simulation on a stream of its own. Detections read their input from there and write their results there, and the
// host need not wait for either.
namespace softcd::test {
namespace {

constexpr int kSteps = 24;
/// Until this step lists have grown, graphs are captured, and the motion of bodies is known.
constexpr int kSteady = 12;

void check(cudaError_t status) {
  ASSERT_EQ(status, cudaSuccess) << cudaGetErrorString(status);
}

/// Blocks work on a stream until the host opens it. It opens by itself after 20 seconds.
class Gate {
 public:
  bool was_opened_in_time() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return was_opened_in_time_;
  }
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_open_ = false;
  }
  void open() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_open_ = true;
    }
    changed_.notify_all();
  }
  /// A cudaHostFn_t.
  static void wait(void* gate) { static_cast<Gate*>(gate)->wait_until_open(); }

 private:
  void wait_until_open() {
    std::unique_lock<std::mutex> lock(mutex_);
    was_opened_in_time_ &= changed_.wait_for(lock, std::chrono::seconds(20), [&] { return is_open_; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_open_ = true;
  bool was_opened_in_time_ = true;
};

/// The simulation's copies of the results of one detection, made on its stream.
struct Seen {
  ContactCounts counts{};
  std::vector<std::byte> contacts;
};

/// Runs with positions in float or, where the parameter says so, double.
class DeviceStreams : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    const std::string reason = why_missing(Backend::cuda);
    if (!reason.empty()) GTEST_SKIP() << reason;
    SceneOptions options;
    options.backend = Backend::cuda;
    scene_.emplace(options);
    SoupOptions of_triangles;
    of_triangles.triangle_count = 300;
    of_triangles.half_extent = 1.5;
    of_triangles.largest = 1.0;
    of_triangles.size_ratio = 8.0;
    of_triangles.joined_share = 0.5;
    const Mesh mesh = triangle_soup(of_triangles);
    body_ = moving(mesh, scattered(mesh, 0.3, 1), everything(0.03F));
    id_ = scene_->add_body(desc());
    query_.emplace(*scene_, query_options(true));
    for (std::optional<DeviceMemory>* const memory : {&t0_, &t1_}) memory->emplace(Backend::cuda, size());
    if (are_doubles()) {
      write_ends<Vec3d>();
    } else {
      write_ends<Vec3f>();
    }
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking));
    check(cudaEventCreateWithFlags(&ready_, cudaEventDisableTiming));
  }
  void TearDown() override {
    gate_.open();
    query_.reset();
    scene_.reset();
    if (stream_ != nullptr) check(cudaStreamDestroy(stream_));
    if (ready_ != nullptr) check(cudaEventDestroy(ready_));
  }

  static QueryOptions query_options(bool on_device) {
    QueryOptions options;
    options.detection = Detection::ccd;
    // Margins that compensate the rounding of doubles need the positions to be there.
    options.accuracy = Accuracy::precise;
    options.contacts_on_device = on_device;
    options.reuse_pairs = false;
    return options;
  }
  BodyDesc desc() const { return {body_.triangles, static_cast<std::uint32_t>(count()), body_.settings}; }
  std::size_t count() const { return body_.x_t0.size(); }
  static bool are_doubles() { return GetParam(); }
  static std::size_t stride() { return are_doubles() ? sizeof(Vec3d) : sizeof(Vec3f); }
  /// Returns the size of a body's positions in bytes.
  std::size_t size() const { return count() * stride(); }

  /// Moves slowly, except in the last step.
  template <class Position>
  static std::vector<Position> end_of_step(const Positions3& x, int step) {
    const Vec3d by = step == kSteps - 1 ? Vec3d{0, 0, 2} : static_cast<double>(step) * Vec3d{0.004, 0.002, -0.003};
    std::vector<Position> end;
    for (const Vec3d& position : x) end.push_back(vec3_cast<decltype(Position::x)>(position + by));
    return end;
  }
  template <class Position>
  void write_ends() {
    for (int step = 0; step < kSteps; ++step) {
      for (const Positions3* const x : {&body_.x_t0, &body_.x_t1}) {
        ends_.emplace_back(Backend::cuda, size()).write(end_of_step<Position>(*x, step).data(), size());
      }
    }
  }
  /// Returns the contacts that the CPU finds in a step.
  std::vector<Contact> expected(int step) const {
    return are_doubles() ? expected_of<Vec3d>(step) : expected_of<Vec3f>(step);
  }
  template <class Position>
  std::vector<Contact> expected_of(int step) const {
    SceneOptions options;
    options.backend = Backend::cpu;
    softcd::Scene scene(options);
    const BodyId id = scene.add_body(desc());
    const std::vector<Position> x_t0 = end_of_step<Position>(body_.x_t0, step);
    const std::vector<Position> x_t1 = end_of_step<Position>(body_.x_t1, step);
    scene.set_positions(id, x_t0, x_t1);
    Query query(scene, query_options(false));
    const Span<const Contact> contacts = query.detect();
    return {contacts.begin(), contacts.end()};
  }

  void copy(DeviceMemory& from, DeviceMemory& to) {
    check(cudaMemcpyAsync(to.data(), from.data(), size(), cudaMemcpyDeviceToDevice, stream_));
  }
  /// Enqueues work that makes a step's positions some time after the gate is open.
  void make_positions(int step) {
    check(cudaLaunchHostFunc(stream_, Gate::wait, &gate_));
    check(cudaLaunchHostFunc(
        stream_, [](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }, nullptr));
    const std::size_t first = 2 * static_cast<std::size_t>(step);
    copy(ends_[first], *t0_);
    copy(ends_[first + 1], *t1_);
    check(cudaEventRecord(ready_, stream_));
  }
  void set_positions() {
    const auto at = [&](DeviceMemory& memory) {
      if (are_doubles()) {
        return Positions::on_device(reinterpret_cast<const double*>(memory.data()), count(), stride(), ready_);
      }
      return Positions::on_device(reinterpret_cast<const float*>(memory.data()), count(), stride(), ready_);
    };
    scene_->set_positions(id_, at(*t0_), at(*t1_));
  }
  /// Enqueues copies of the results, once they are there.
  void read(const PendingContacts& found, Seen& seen) {
    check(cudaStreamWaitEvent(stream_, static_cast<cudaEvent_t>(found.ready), 0));
    seen.contacts.resize(found.capacity * sizeof(Contact));
    check(cudaMemcpyAsync(&seen.counts, found.counts, sizeof(ContactCounts), cudaMemcpyDeviceToHost, stream_));
    check(cudaMemcpyAsync(seen.contacts.data(), found.data, seen.contacts.size(), cudaMemcpyDeviceToHost, stream_));
  }
  /// Enqueues work that overwrites the positions with useless values.
  void destroy_positions() {
    for (DeviceMemory* const x : {&*t0_, &*t1_}) {
      check(cudaMemsetAsync(x->data(), 0xFF, size(), stream_));
    }
  }

  Gate gate_;
  SceneBody body_;
  std::optional<softcd::Scene> scene_;
  std::optional<Query> query_;
  BodyId id_;
  cudaStream_t stream_ = nullptr;
  cudaEvent_t ready_ = nullptr;
  std::optional<DeviceMemory> t0_, t1_;  ///< memory that the scene reads
  std::vector<DeviceMemory> ends_;       ///< of all steps
};

TEST_P(DeviceStreams, detections_see_what_comes_before_them_and_nothing_after) {
  for (int step = 0; step < kSteps; ++step) {
    make_positions(step);
    set_positions();
    const DeviceContacts found = query_->detect_on_device();
    destroy_positions();
    const std::vector<Contact> contacts = expected(step);
    ASSERT_GT(contacts.size(), 100U);
    ASSERT_EQ(found.count, contacts.size()) << "step " << step;
    const std::vector<std::byte> bytes = read_device(Backend::cuda, found.data, found.count * sizeof(Contact));
    EXPECT_EQ(std::memcmp(bytes.data(), contacts.data(), bytes.size()), 0) << "step " << step;
  }
}

/// While the gate is closed there are no positions yet: a caller that waits for them waits for ever.
TEST_P(DeviceStreams, detections_that_nobody_reads_on_the_host_are_started_without_waiting) {
  for (int step = 0; step < kSteps; ++step) {
    const bool is_steady = step >= kSteady;
    if (is_steady) gate_.close();
    make_positions(step);
    set_positions();
    const std::uint64_t waits = cuda_waits();
    Ticket ticket = query_->start();
    const PendingContacts pending = ticket.on_device();
    if (is_steady) {
      EXPECT_EQ(cuda_waits(), waits) << "step " << step;
    }
    ASSERT_NE(pending.counts, nullptr);
    std::optional<Seen> seen;
    gate_.open();
    EXPECT_TRUE(gate_.was_opened_in_time()) << "step " << step;
    if (is_steady) read(pending, seen.emplace());
    check(cudaStreamSynchronize(stream_));
    const DeviceContacts found = ticket.wait_on_device();
    const std::vector<Contact> contacts = expected(step);
    ASSERT_EQ(found.count, contacts.size()) << "step " << step;
    if (seen) {
      EXPECT_EQ(seen->counts.is_complete, step < kSteps - 1 ? 1U : 0U) << "step " << step;
    }
    if (seen && seen->counts.is_complete == 1) {
      ASSERT_EQ(seen->counts.contacts, contacts.size()) << "step " << step;
      EXPECT_EQ(std::memcmp(seen->contacts.data(), contacts.data(), contacts.size() * sizeof(Contact)), 0);
    }
    destroy_positions();
  }
}

INSTANTIATE_TEST_SUITE_P(Positions, DeviceStreams, testing::Bool(),
                         [](const testing::TestParamInfo<bool>& of) { return of.param ? "doubles" : "floats"; });

}  // namespace
}  // namespace softcd::test
