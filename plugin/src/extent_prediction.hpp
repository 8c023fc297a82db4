#pragma once

#include <cstdint>
#include <vector>

#include "body.hpp"

namespace softcd {

/// Predicts the extents of bodies whose positions are on a device. The prediction is the extent that was read last,
/// enlarged by the body's motion over several detections. A detection that uses a prediction need not wait until the
/// device's positions have been read.
///
/// A prediction holds until a body leaves it, or something other than positions changes. Where predictions seldom hold
/// for long, none are made for some time. Owned by ScenePositions.
class ExtentPrediction {
 public:
  /// Returns whether a prediction exists.
  bool is_known() const { return is_known_; }
  /// Returns the prediction for a body, by its index among all bodies.
  const StepSurvey& of(std::size_t body) const { return predicted_[body]; }
  /// Returns the prediction's number, which changes with each new prediction. Never 0.
  std::uint64_t number() const { return number_; }

  /// Takes the extents of all bodies, which have just been read. Makes a new prediction where there is none, or where
  /// the present one will soon fail, unless bodies are too fast.
  void learn(const std::vector<Body>& bodies);
  /// Records that the prediction was right.
  void confirm() { ++detections_; }
  /// Records that the prediction was wrong.
  void fail();
  /// Drops the prediction: bodies, or the required ends of the step, have changed.
  void forget();

 private:
  /// The number of detections for which a prediction should hold.
  static constexpr int kDetections = 8;
  static constexpr int kFewestDetections = 3;
  /// The number of detections without predictions, after one that held for fewer than kFewestDetections.
  static constexpr int kRest = 32;
  /// The largest enlargement, in diagonals of the body. With more, too many other bodies would be near it.
  static constexpr double kMostSlack = 0.1;

  bool has_room(const std::vector<double>& moves) const;
  void predict(const std::vector<double>& moves);

  bool is_known_ = false;
  std::uint64_t number_ = 1;
  int detections_ = 0;            ///< detections for which the prediction has held
  int detections_to_rest_ = 0;    ///< detections until the next prediction
  std::vector<StepSurvey> seen_;  ///< extents of all bodies, as read last; empty where unknown
  std::vector<StepSurvey> predicted_;
};

}  // namespace softcd
