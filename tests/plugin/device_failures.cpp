#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <string>
#include <vector>

#include "body.hpp"
#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "pair_selection.hpp"
#include "scene.hpp"
#include "scene_snapshot.hpp"
#include "selected_detector.hpp"

namespace softcd::test {
namespace {

enum class Failing { nothing, construction, topology, positions, start, finish };

struct Fault {
  Failing where = Failing::nothing;
  bool is_memory = false;
  int devices_made = 0;

  void at(Failing here) const {
    if (here != where) return;
    if (is_memory) throw std::bad_alloc();
    throw DeviceError("the device fell off the bus");
  }
};

/// Computes on the CPU, in memory of its own that is gone with it, and fails when told to.
class FaultyDevice final : public Detector {
 public:
  explicit FaultyDevice(Fault& fault) : fault_(fault), detector_(make_cpu_detector()) {
    ++fault_.devices_made;
    fault_.at(Failing::construction);
  }

  bool set_memory_limit(std::uint64_t bytes) override { return detector_->set_memory_limit(bytes); }
  void set_topology(const SceneTopology& topology) override {
    fault_.at(Failing::topology);
    detector_->set_topology(topology);
  }
  PositionArrays position_arrays() override {
    fault_.at(Failing::positions);
    return detector_->position_arrays();
  }
  void start(const SceneBodies& bodies, const DetectionSettings& settings) override {
    fault_.at(Failing::start);
    detector_->start(bodies, settings);
  }
  Span<const Contact> finish(Statistics& statistics) override {
    const Span<const Contact> contacts = detector_->finish(statistics);
    fault_.at(Failing::finish);
    return contacts;
  }
  void report_memory(Statistics& statistics) const override { detector_->report_memory(statistics); }

 private:
  Fault& fault_;
  std::unique_ptr<Detector> detector_;
};

/// What a pipeline does around its detector, for one body.
class DeviceFailures : public testing::Test {
 protected:
  DeviceFailures() : body_(moving(sheet(), scattered(sheet(), 0.4, 3), everything(0.05F))) {
    const auto vertex_count = static_cast<std::uint32_t>(body_.x_t0.size());
    bodies_.push_back(make_body(BodyId{0}, {body_.triangles, vertex_count, body_.settings}));
    bodies_[0].positions.set(body_.x_t0, body_.x_t1);
    scene_ = concatenate(bodies_);
  }

  static Mesh sheet() {
    SoupOptions options;
    options.triangle_count = 400;
    options.half_extent = 2.0;
    options.joined_share = 0.5;
    return triangle_soup(options);
  }

  std::unique_ptr<SelectedDetector> detector(Backend wanted = Backend::automatic) {
    const auto log = [this](LogLevel level, std::string_view message) {
      if (level == LogLevel::warning) warnings_.emplace_back(message);
    };
    return std::make_unique<SelectedDetector>(
        wanted, log, [this] { return std::make_unique<FaultyDevice>(fault_); }, "");
  }

  std::vector<Contact> detect(SelectedDetector& detector, Detection detection = Detection::ccd) {
    const bool continuous = detection == Detection::ccd;
    std::vector<BodySurvey> surveys = survey_bodies(bodies_, continuous, false);
    const PairSelection pairs = select_pairs(bodies_, surveys, {0, 0, 0}, {}, {});
    detector.set_topology(scene_.topology());
    write_positions(bodies_, {0, 0, 0}, continuous, detector.position_arrays(), surveys);
    detector.start(pairs.view(), {detection, Accuracy::precise, BroadPhase::exact, true, 1.8F, 0.0F,
                                  ContactRule::distance, true, true, continuous});
    const Span<const Contact> contacts = detector.finish(statistics_);
    return {contacts.begin(), contacts.end()};
  }

  std::vector<Contact> expected(Detection detection) {
    SelectedDetector cpu(Backend::cpu, {}, {}, "");
    return detect(cpu, detection);
  }

  SceneBody body_;
  std::vector<Body> bodies_;
  SceneArrays scene_;
  Fault fault_;
  Statistics statistics_;
  std::vector<std::string> warnings_;
};

TEST_F(DeviceFailures, the_cpu_repeats_the_detection_with_the_same_contacts) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const std::vector<Contact> contacts = expected(detection);
    ASSERT_GT(contacts.size(), 100U);
    for (const Failing where :
         {Failing::construction, Failing::topology, Failing::positions, Failing::start, Failing::finish}) {
      for (const bool is_memory : {false, true}) {
        fault_ = {where, is_memory};
        warnings_.clear();
        const auto failing = detector();
        EXPECT_EQ(failing->backend(), Backend::cuda);
        EXPECT_TRUE(identical(contacts, detect(*failing, detection)));
        EXPECT_EQ(statistics_.backend, Backend::cpu);
        EXPECT_EQ(failing->backend(), Backend::cpu);
        EXPECT_TRUE(identical(contacts, detect(*failing, detection)));
        ASSERT_EQ(warnings_.size(), 1U) << "one warning, however many detections";
        EXPECT_THAT(warnings_[0], testing::HasSubstr(is_memory ? "memory" : "fell off the bus"));
      }
    }
  }
}

TEST_F(DeviceFailures, nobody_takes_over_where_cuda_was_asked_for) {
  const std::vector<Contact> contacts = expected(Detection::ccd);
  for (const Failing where :
       {Failing::construction, Failing::topology, Failing::positions, Failing::start, Failing::finish}) {
    const auto failing = detector(Backend::cuda);
    fault_ = {where, false};
    try {
      detect(*failing);
      ADD_FAILURE() << "no exception";
    } catch (const BackendError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("fell off the bus"));
      EXPECT_THAT(error.what(), testing::HasSubstr("Backend::automatic"));
    }
    fault_ = {where, true};
    EXPECT_THROW(detect(*failing), std::bad_alloc);
    fault_ = {};
    EXPECT_TRUE(identical(contacts, detect(*failing))) << "the device is tried again";
    EXPECT_EQ(statistics_.backend, Backend::cuda);
    EXPECT_EQ(failing->backend(), Backend::cuda);
  }
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(DeviceFailures, a_failed_device_is_not_tried_again) {
  fault_ = {Failing::finish, false};
  const auto failing = detector();
  detect(*failing);
  fault_.where = Failing::nothing;
  detect(*failing);
  EXPECT_EQ(failing->backend(), Backend::cpu);
  EXPECT_EQ(fault_.devices_made, 1);
}

TEST_F(DeviceFailures, a_device_whose_memory_ran_out_is_tried_again) {
  fault_ = {Failing::finish, true};
  const auto failing = detector();
  detect(*failing);
  fault_.where = Failing::nothing;
  const std::vector<Contact> contacts = expected(Detection::ccd);
  EXPECT_TRUE(identical(contacts, detect(*failing)));
  EXPECT_EQ(failing->backend(), Backend::cuda);
  EXPECT_EQ(statistics_.backend, Backend::cuda);
  EXPECT_EQ(fault_.devices_made, 2);
}

TEST_F(DeviceFailures, small_scenes_stay_on_the_cpu_unless_cuda_was_asked_for) {
  const auto automatic = detector(Backend::automatic);
  detect(*automatic);
  EXPECT_EQ(automatic->backend(), Backend::cuda);
  const auto cuda = detector(Backend::cuda);
  scene_.triangles.resize(kSmallScene - 1);
  automatic->set_topology(scene_.topology());
  cuda->set_topology(scene_.topology());
  automatic->position_arrays();
  cuda->position_arrays();
  EXPECT_EQ(automatic->backend(), Backend::cpu);
  EXPECT_THAT(automatic->reason(), testing::HasSubstr(std::to_string(kSmallScene - 1)));
  EXPECT_EQ(cuda->backend(), Backend::cuda);
}

TEST_F(DeviceFailures, no_device_is_an_error_only_when_one_was_asked_for) {
  EXPECT_THROW(SelectedDetector(Backend::cuda, {}, {}, "it is a toaster"), BackendError);
  const SelectedDetector automatic(Backend::automatic, {}, {}, "it is a toaster");
  EXPECT_EQ(automatic.backend(), Backend::cpu);
  EXPECT_THAT(automatic.reason(), testing::HasSubstr("it is a toaster"));
}

}  // namespace
}  // namespace softcd::test
