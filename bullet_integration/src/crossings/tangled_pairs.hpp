#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// Why a pair of bodies is through each other.
enum class TangleReason : std::uint8_t {
  start,        ///< it was so when a step began, so that it was let go
  unavoidable,  ///< somebody else has moved the one through the other
};

/// Pairs of bodies with features that are through each other: each from the step in which this is so for the first time
/// until none of the features that were added since is through anything. So a pair that stays tangled is new once, for
/// one reason. Bodies that are gone are none any more; ones with other faces are where none of these is through
/// anything in the step in which they are new.
class TangledPairs {
 public:
  /// Before add(), when the mirror has the bodies as they are in this step.
  void begin_step(const WorldMirror& mirror, const NodeEnds& ends);
  void add(const Contact& found, TangleReason reason);
  /// "soft bodies 0 and 3, 2 within itself" of those that are new in this step for this reason, by their numbers in
  /// `bodies`; what is none of these stands for a rigid mesh. Empty where none are.
  std::string describe_new(TangleReason reason, const WorldMirror& mirror, Span<btSoftBody* const> bodies) const;

 private:
  struct Features {
    TangleReason reason;
    std::vector<Contact> contacts = {};
    bool is_new = true;
  };

  std::map<std::pair<std::uint32_t, std::uint32_t>, Features> pairs_;  ///< by the bodies' ids, the smaller one first
};

}  // namespace softcd::bullet
