#pragma once

#include <cstdint>
#include <vector>

#include "body.hpp"

namespace softcd {

/// Where bodies whose positions are on a device will be: where they were seen last, and as far around that as they have
/// moved before in some looks. A detection that takes this for granted need not wait until somebody has looked. It
/// stands until a body leaves it, or something else changes than positions; where it seldom stands for long nothing is
/// foreseen for some time.
class Foresight {
 public:
  /// Whether something is foreseen.
  bool is_known() const { return is_known_; }
  /// Of a body, by its place among all.
  const StepSurvey& of(std::size_t body) const { return foreseen_[body]; }
  /// Another one for whatever is foreseen anew; never 0.
  std::uint64_t number() const { return number_; }

  /// All bodies have been seen. Foresees where they will be, where that is not known or will soon not be so, unless
  /// they are too fast.
  void learn(const std::vector<Body>& bodies);
  /// What was foreseen was so.
  void confirm() { ++looks_; }
  /// It was not.
  void fail();
  /// Other bodies are to be seen, or the same ones otherwise.
  void forget();

 private:
  /// That what is foreseen should stand.
  static constexpr int kLooks = 8;
  static constexpr int kFewestLooks = 3;
  /// In which nothing is foreseen where fewer are between two in vain.
  static constexpr int kRest = 32;
  /// More around a body, in diagonals of it, has too many others near it.
  static constexpr double kMostSlack = 0.1;

  bool has_room(const std::vector<double>& moves) const;
  void foresee(const std::vector<double>& moves);

  bool is_known_ = false;
  std::uint64_t number_ = 1;
  int looks_ = 0;                 ///< for which it has stood
  int looks_to_rest_ = 0;         ///< before something is foreseen again
  std::vector<StepSurvey> seen_;  ///< of all bodies, by the last look; empty where that is not known
  std::vector<StepSurvey> foreseen_;
};

}  // namespace softcd
