#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// The failures of one part of softcd. The log names the first.
class Failures {
 public:
  /// `outcome` begins the warning, as in "the step has Bullet's own contacts".
  explicit Failures(const char* outcome) : outcome_(outcome) {}

  /// Counts and logs the exception that is being handled. Rethrows it if it is not softcd's, or with
  /// OnError::throw_error.
  void note(const Settings& settings);
  std::uint64_t count() const { return count_; }

 private:
  void go_on(const Settings& settings, const char* cause);

  const char* outcome_;
  std::uint64_t count_ = 0;
  bool has_warned_ = false;
};

/// Reports on a detector, also when it has failed and is gone.
class DetectorRecord {
 public:
  DetectorRecord(const char* outcome_of_failures, const Scene& scene) : failures_(outcome_of_failures), scene_(scene) {}

  using Explain = std::function<std::vector<StageReport>()>;

  /// Sets the detector's query and explanation, or null and none if there is no detector. They must live until the next
  /// call.
  void set_detector(const Query* query, Explain explain);
  void note_failure(const Settings& settings) { failures_.note(settings); }

  const Statistics& statistics() const { return query_ != nullptr ? query_->statistics() : statistics_; }
  std::vector<StageReport> explain() const { return explain_ ? explain_() : std::vector<StageReport>(); }
  Backend backend() const { return scene_.backend(); }
  std::uint64_t failed_steps() const { return failures_.count(); }

 private:
  Failures failures_;
  const Scene& scene_;
  const Query* query_ = nullptr;
  Explain explain_;
  Statistics statistics_;  ///< of the query before
};

/// Owns a detector that no failure leaves half done: a failed detector is destroyed, and the next step that needs one
/// makes another.
template <class Detector>
class Guarded {
 public:
  using Kind = typename Detector::Kind;

  /// `kind`, `mirror` and `settings` outlive it.
  Guarded(const char* outcome_of_failures, const Kind& kind, WorldMirror& mirror, const Settings& settings)
      : kind_(kind), mirror_(mirror), settings_(settings), record_(outcome_of_failures, mirror.scene()) {
    make();
  }

  /// Calls work(Detector&). Returns false if it has failed; the step then continues without it.
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

  /// Applies changed settings.
  void follow_settings() {
    if (detector_ != nullptr) detector_->follow_settings();
  }

  /// Returns null after a failure.
  Detector* get() const { return detector_.get(); }
  const DetectorRecord& record() const { return record_; }

 private:
  void make() {
    detector_ = std::make_unique<Detector>(kind_, mirror_, settings_);
    const Query* query = nullptr;
    if constexpr (requires(const Detector& detector) { detector.query(); }) query = &detector_->query();
    record_.set_detector(query, [detector = detector_.get()] { return detector->explain(); });
  }

  const Kind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  std::unique_ptr<Detector> detector_;
  DetectorRecord record_;
};

}  // namespace softcd::bullet
