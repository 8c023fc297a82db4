#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

struct WorldKind;

/// What is known of a detector, whether it is there or has failed.
class DetectorRecord {
 public:
  /// `instead` completes the sentence that tells of a failure: what the step goes on with.
  explicit DetectorRecord(const char* instead) : instead_(instead) {}

  /// The detector's; null when there is none. It is kept until the next call.
  void set_pipeline(const CollisionPipeline* pipeline);
  /// To be called while an exception is handled: throws it on unless it is softcd's and the step shall go on.
  void note_failure(const Settings& settings);

  const Statistics& statistics() const { return pipeline_ != nullptr ? pipeline_->statistics() : statistics_; }
  std::vector<StageReport> explain() const;
  Backend backend() const { return pipeline_ != nullptr ? pipeline_->backend() : backend_; }
  std::uint64_t failed_steps() const { return failed_steps_; }

 private:
  void go_on(const Settings& settings, const char* cause);

  const char* instead_;
  const CollisionPipeline* pipeline_ = nullptr;
  Statistics statistics_;  ///< of the pipeline before
  Backend backend_ = Backend::cpu;
  std::uint64_t failed_steps_ = 0;
  bool has_warned_ = false;
};

/// A detector that no failure leaves half done: it is thrown away then, and made anew when it is needed again.
template <class Detector>
class Guarded {
 public:
  Guarded(const char* instead, const WorldKind& kind, const Settings& settings) : kind_(kind), record_(instead) {
    make(settings);
  }

  /// Calls work(Detector&). False when it has failed, and the step goes on without.
  template <class Work>
  bool run(const Settings& settings, Work work) {
    try {
      if (detector_ == nullptr) make(settings);
      work(*detector_);
      return true;
    } catch (...) {
      record_.set_pipeline(nullptr);
      detector_.reset();
      record_.note_failure(settings);
      return false;
    }
  }

  /// Null after a failure.
  Detector* get() const { return detector_.get(); }
  const DetectorRecord& record() const { return record_; }

 private:
  void make(const Settings& settings) {
    detector_ = std::make_unique<Detector>(kind_, settings);
    record_.set_pipeline(&detector_->pipeline());
  }

  const WorldKind& kind_;
  std::unique_ptr<Detector> detector_;
  DetectorRecord record_;
};

}  // namespace softcd::bullet
