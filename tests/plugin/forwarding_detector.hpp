#pragma once

#include <memory>

#include "softcd/pipeline/detector.hpp"

namespace softcd::test {

/// Forwards all calls to the CPU's detector. Base of detectors that differ in a few calls.
class ForwardingDetector : public Detector {
 public:
  bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) override {
    return detector_->set_memory_limit(bytes, query);
  }
  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    detector_->set_scene(scene, changes);
  }
  std::unique_ptr<QueryMemory> make_query() override { return detector_->make_query(); }
  void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) override {
    detector_->start(query, bodies, settings);
  }
  StayingContacts staying() const override { return detector_->staying(); }
  Span<const Contact> finish(Statistics& statistics) override { return detector_->finish(statistics); }
  std::unique_ptr<QueryMemory> make_probe() override { return detector_->make_probe(); }
  void answer(QueryMemory& probe, const ProbedScene& scene, const Questions& ask) override {
    detector_->answer(probe, scene, ask);
  }
  void report_memory(Statistics& statistics) const override { detector_->report_memory(statistics); }
  MemoryNeed memory_need() const override { return detector_->memory_need(); }
  TestSamples test_samples() const override { return detector_->test_samples(); }

 private:
  std::unique_ptr<Detector> detector_ = make_cpu_detector();
};

}  // namespace softcd::test
