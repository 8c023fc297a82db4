#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// What is known of a detector, whether it is there or has failed.
class DetectorRecord {
 public:
  /// `instead` completes the sentence that tells of a failure: what the step goes on with.
  DetectorRecord(const char* instead, const Scene& scene) : instead_(instead), scene_(scene) {}

  using Explain = std::function<std::vector<StageReport>()>;

  /// The detector's; null and none when there is none. They are kept until the next call.
  void set_detector(const Query* query, Explain explain);
  /// To be called while an exception is handled: throws it on unless it is softcd's and the step shall go on.
  void note_failure(const Settings& settings);

  const Statistics& statistics() const { return query_ != nullptr ? query_->statistics() : statistics_; }
  std::vector<StageReport> explain() const { return explain_ ? explain_() : std::vector<StageReport>(); }
  Backend backend() const { return scene_.backend(); }
  std::uint64_t failed_steps() const { return failed_steps_; }

 private:
  void go_on(const Settings& settings, const char* cause);

  const char* instead_;
  const Scene& scene_;
  const Query* query_ = nullptr;
  Explain explain_;
  Statistics statistics_;  ///< of the query before
  std::uint64_t failed_steps_ = 0;
  bool has_warned_ = false;
};

/// A detector that no failure leaves half done: it is thrown away then, and made anew when it is needed again.
template <class Detector>
class Guarded {
 public:
  using Kind = typename Detector::Kind;

  /// `kind`, `mirror` and `settings` outlive it.
  Guarded(const char* instead, const Kind& kind, WorldMirror& mirror, const Settings& settings)
      : kind_(kind), mirror_(mirror), settings_(settings), record_(instead, mirror.scene()) {
    make();
  }

  /// Calls work(Detector&). False when it has failed, and the step goes on without.
  template <class Work>
  bool run(Work work) {
    try {
      if (detector_ == nullptr) make();
      work(*detector_);
      return true;
    } catch (...) {
      mirror_.forget_all();
      record_.set_detector(nullptr, {});
      detector_.reset();
      record_.note_failure(settings_);
      return false;
    }
  }

  /// The settings have changed.
  void follow_settings() {
    if (detector_ != nullptr) detector_->follow_settings();
  }

  /// Null after a failure.
  Detector* get() const { return detector_.get(); }
  const DetectorRecord& record() const { return record_; }

 private:
  void make() {
    detector_ = std::make_unique<Detector>(kind_, mirror_, settings_);
    record_.set_detector(&detector_->query(), [detector = detector_.get()] { return detector->explain(); });
  }

  const Kind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  std::unique_ptr<Detector> detector_;
  DetectorRecord record_;
};

}  // namespace softcd::bullet
