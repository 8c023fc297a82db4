#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "probe_core.hpp"
#include "query_core.hpp"
#include "scene.hpp"
#include "scene_parts.hpp"
#include "selected_detector.hpp"

namespace softcd::test {
namespace {

enum class Failing { nothing, construction, query, scene, start, finish, probe, answer };

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

/// Computes on the CPU, in memory of its own, and fails on request.
class FaultyDevice final : public Detector {
 public:
  explicit FaultyDevice(Fault& fault) : fault_(fault), detector_(make_cpu_detector()) {
    ++fault_.devices_made;
    fault_.at(Failing::construction);
  }

  bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) override {
    return detector_->set_memory_limit(bytes, query);
  }
  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    fault_.at(Failing::scene);
    detector_->set_scene(scene, changes);
  }
  std::unique_ptr<QueryMemory> make_query() override {
    fault_.at(Failing::query);
    return detector_->make_query();
  }
  void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) override {
    fault_.at(Failing::start);
    detector_->start(query, bodies, settings);
  }
  StayingContacts staying() const override { return detector_->staying(); }
  Span<const Contact> finish(Statistics& statistics) override {
    const Span<const Contact> contacts = detector_->finish(statistics);
    fault_.at(Failing::finish);
    return contacts;
  }
  std::unique_ptr<QueryMemory> make_probe() override {
    fault_.at(Failing::probe);
    return detector_->make_probe();
  }
  void answer(QueryMemory& probe, const ProbedScene& scene, const Questions& ask) override {
    detector_->answer(probe, scene, ask);
    fault_.at(Failing::answer);
  }
  void report_memory(Statistics& statistics) const override { detector_->report_memory(statistics); }
  MemoryNeed memory_need() const override { return detector_->memory_need(); }
  TestSamples test_samples() const override { return detector_->test_samples(); }

 private:
  Fault& fault_;
  std::unique_ptr<Detector> detector_;
};

/// A scene with one query and a device that fails.
class FailingScene {
 public:
  FailingScene(Backend wanted, Fault& fault, const SceneBody& body, std::vector<std::string>& warnings,
               const Communicator& communicator = {})
      : scene_(std::make_shared<detail::SceneCore>(
            options(wanted, communicator),
            [&warnings](LogLevel level, std::string_view message) {
              if (level == LogLevel::warning) warnings.emplace_back(message);
            },
            DetectorFactories{make_cpu_detector, [&fault] { return std::make_unique<FaultyDevice>(fault); }, ""})),
        query_(scene_, {}),
        probe_(scene_, {}) {
    const auto vertex_count = static_cast<std::uint32_t>(body.x_t0.size());
    const BodyId id = scene_->add_body({body.triangles, vertex_count, body.settings});
    scene_->set_positions(id, body.x_t0, body.x_t1);
  }

  Backend backend() const { return scene_->backend(); }
  std::string reason() const { return scene_->backend_reason(); }
  const Statistics& statistics() const { return query_.statistics(); }

  std::vector<Contact> detect(Detection detection = Detection::ccd) {
    query_.set_options(looking_for(detection));
    return copy_of(query_.wait(query_.start(Pairs::all)));
  }

  std::vector<Contact> gather() { return query_.gather_contacts(); }

  /// Returns the number of hits of a ray straight through the scene.
  std::size_t hits() {
    const Ray ray{{0.1, 0.2, 100}, {0, 0, -1}};
    return probe_.all_hits({&ray, 1})[0].size();
  }

 private:
  static SceneOptions options(Backend wanted, const Communicator& communicator) {
    SceneOptions result = scene_options(wanted);
    result.communicator = communicator;
    return result;
  }

  std::shared_ptr<detail::SceneCore> scene_;
  detail::QueryCore query_;
  detail::ProbeCore probe_;
};

class DeviceFailures : public testing::Test {
 protected:
  static SceneBody soup(std::uint32_t triangle_count) {
    SoupOptions options;
    options.triangle_count = triangle_count;
    options.half_extent = 2.0;
    options.joined_share = 0.5;
    const Mesh mesh = triangle_soup(options);
    return moving(mesh, scattered(mesh, 0.4, 3), everything(0.05F));
  }

  FailingScene scene(Backend wanted = Backend::automatic) { return {wanted, fault_, body_, warnings_}; }

  std::vector<Contact> expected(Detection detection) { return detect_once({body_}, cpu_options(detection)); }

  static PipelineOptions cpu_options(Detection detection) {
    PipelineOptions options;
    options.backend = Backend::cpu;
    options.detection = detection;
    options.accuracy = Accuracy::precise;
    return options;
  }

  SceneBody body_ = soup(400);
  Fault fault_;
  std::vector<std::string> warnings_;
};

TEST_F(DeviceFailures, the_cpu_repeats_the_detection_with_the_same_contacts) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const std::vector<Contact> contacts = expected(detection);
    ASSERT_GT(contacts.size(), 100U);
    for (const Failing where :
         {Failing::construction, Failing::query, Failing::scene, Failing::start, Failing::finish}) {
      for (const bool is_memory : {false, true}) {
        fault_ = {where, is_memory};
        warnings_.clear();
        FailingScene failing = scene();
        EXPECT_EQ(failing.backend(), Backend::cuda);
        EXPECT_TRUE(identical(contacts, failing.detect(detection)));
        EXPECT_EQ(failing.statistics().backend, Backend::cpu);
        EXPECT_EQ(failing.backend(), Backend::cpu);
        EXPECT_TRUE(identical(contacts, failing.detect(detection)));
        ASSERT_EQ(warnings_.size(), 1U) << "one warning, however many detections";
        EXPECT_THAT(warnings_[0], testing::HasSubstr(is_memory ? "memory" : "fell off the bus"));
      }
    }
  }
}

TEST_F(DeviceFailures, nobody_takes_over_where_cuda_was_asked_for) {
  const std::vector<Contact> contacts = expected(Detection::ccd);
  for (const Failing where : {Failing::construction, Failing::query, Failing::scene, Failing::start, Failing::finish}) {
    FailingScene failing = scene(Backend::cuda);
    fault_ = {where, false};
    try {
      failing.detect();
      ADD_FAILURE() << "no exception";
    } catch (const BackendError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("fell off the bus"));
      EXPECT_THAT(error.what(), testing::HasSubstr("Backend::automatic"));
    }
    fault_ = {where, true};
    try {
      failing.detect();
      ADD_FAILURE() << "no exception";
    } catch (const OutOfMemory& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(where == Failing::finish ? "for lists of the cells" : "for a copy"));
      EXPECT_THAT(error.what(), testing::HasSubstr("on the GPU"));
    }
    fault_ = {};
    EXPECT_TRUE(identical(contacts, failing.detect())) << "the device is tried again";
    EXPECT_EQ(failing.statistics().backend, Backend::cuda);
    EXPECT_EQ(failing.backend(), Backend::cuda);
  }
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(DeviceFailures, the_cpu_answers_instead) {
  FailingScene sound = scene();
  const std::size_t hits = sound.hits();
  EXPECT_GT(hits, 5U);
  EXPECT_EQ(sound.backend(), Backend::cuda);
  for (const Failing where : {Failing::construction, Failing::probe, Failing::scene, Failing::answer}) {
    for (const bool is_memory : {false, true}) {
      fault_ = {where, is_memory};
      warnings_.clear();
      FailingScene failing = scene();
      EXPECT_EQ(failing.hits(), hits);
      EXPECT_EQ(failing.backend(), Backend::cpu);
      EXPECT_EQ(failing.hits(), hits);
      EXPECT_EQ(warnings_.size(), 1U);
      fault_ = {};
      FailingScene wanted = scene(Backend::cuda);
      fault_ = {where, is_memory};
      if (is_memory) {
        EXPECT_THROW(wanted.hits(), OutOfMemory);
      } else {
        EXPECT_THROW(wanted.hits(), BackendError);
      }
      fault_ = {};
      EXPECT_EQ(wanted.hits(), hits);
      EXPECT_EQ(wanted.backend(), Backend::cuda);
    }
  }
}

TEST_F(DeviceFailures, a_failed_device_is_not_tried_again) {
  fault_ = {Failing::finish, false};
  FailingScene failing = scene();
  failing.detect();
  fault_.where = Failing::nothing;
  failing.detect();
  EXPECT_EQ(failing.backend(), Backend::cpu);
  EXPECT_EQ(fault_.devices_made, 1);
}

TEST_F(DeviceFailures, a_device_whose_memory_ran_out_is_tried_again) {
  fault_ = {Failing::finish, true};
  FailingScene failing = scene();
  failing.detect();
  fault_.where = Failing::nothing;
  const std::vector<Contact> contacts = expected(Detection::ccd);
  EXPECT_TRUE(identical(contacts, failing.detect()));
  EXPECT_EQ(failing.backend(), Backend::cuda);
  EXPECT_EQ(failing.statistics().backend, Backend::cuda);
  EXPECT_EQ(fault_.devices_made, 2);
}

TEST_F(DeviceFailures, small_scenes_stay_on_the_cpu_unless_cuda_was_asked_for) {
  FailingScene large = scene();
  large.detect();
  EXPECT_EQ(large.backend(), Backend::cuda);
  body_ = soup(kSmallScene - 1);
  FailingScene little = scene();
  little.detect();
  EXPECT_EQ(little.backend(), Backend::cpu);
  EXPECT_THAT(little.reason(), testing::HasSubstr(std::to_string(kSmallScene - 1)));
  FailingScene wanted = scene(Backend::cuda);
  wanted.detect();
  EXPECT_EQ(wanted.backend(), Backend::cuda);
}

TEST_F(DeviceFailures, no_device_is_an_error_only_when_one_was_asked_for) {
  const DetectorFactories without_device = {make_cpu_detector, {}, "it is a toaster"};
  EXPECT_THROW(SelectedDetector(Backend::cuda, {}, without_device), BackendError);
  const SelectedDetector automatic(Backend::automatic, {}, without_device);
  EXPECT_EQ(automatic.backend(), Backend::cpu);
  EXPECT_THAT(automatic.reason(), testing::HasSubstr("it is a toaster"));
}

/// The contacts or the error of each of two ranks, where the second one's device fails.
struct RankOutcome {
  std::vector<Contact> all;
  std::string problem;
  Backend backend = Backend::automatic;
};
std::vector<RankOutcome> detect_on_ranks(Backend wanted, std::array<Fault, 2>& faults, const SceneBody& body) {
  const std::vector<Communicator> ranks = Communicator::of_threads(2);
  std::vector<RankOutcome> outcomes(2);
  std::vector<std::thread> threads;
  for (std::size_t rank = 0; rank < 2; ++rank) {
    threads.emplace_back([&, rank] {
      std::vector<std::string> warnings;
      FailingScene failing(wanted, faults[rank], body, warnings, ranks[rank]);
      try {
        failing.detect();
      } catch (const BackendError& error) {
        outcomes[rank].problem = error.what();
        faults[rank].where = Failing::nothing;
        failing.detect();  // on all ranks, the device is tried again
      }
      outcomes[rank].all = failing.gather();
      outcomes[rank].backend = failing.backend();
    });
  }
  for (std::thread& thread : threads) thread.join();
  return outcomes;
}

TEST_F(DeviceFailures, one_rank_s_are_told_to_all_of_them) {
  const std::vector<Contact> contacts = expected(Detection::ccd);
  for (const Failing where : {Failing::construction, Failing::query, Failing::scene, Failing::start, Failing::finish}) {
    std::array<Fault, 2> faults{Fault{}, Fault{where}};
    const std::vector<RankOutcome> outcomes = detect_on_ranks(Backend::cuda, faults, body_);
    EXPECT_THAT(outcomes[0].problem, testing::HasSubstr("rank 1: the device fell off the bus"));
    EXPECT_EQ(outcomes[1].problem, outcomes[0].problem);
    for (const RankOutcome& outcome : outcomes) EXPECT_TRUE(identical(contacts, outcome.all));
  }
}

TEST_F(DeviceFailures, the_cpu_takes_over_one_rank_s_part) {
  const std::vector<Contact> contacts = expected(Detection::ccd);
  for (const Failing where : {Failing::construction, Failing::query, Failing::scene, Failing::start, Failing::finish}) {
    std::array<Fault, 2> faults{Fault{}, Fault{where}};
    const std::vector<RankOutcome> outcomes = detect_on_ranks(Backend::automatic, faults, body_);
    EXPECT_EQ(outcomes[0].backend, Backend::cuda);
    EXPECT_EQ(outcomes[1].backend, Backend::cpu);
    for (const RankOutcome& outcome : outcomes) {
      EXPECT_EQ(outcome.problem, "");
      EXPECT_TRUE(identical(contacts, outcome.all));
    }
  }
}

}  // namespace
}  // namespace softcd::test
