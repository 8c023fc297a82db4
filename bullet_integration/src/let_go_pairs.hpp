#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "world_mirror.hpp"

namespace softcd::bullet {

/// Pairs of bodies with features that are let go because they are through each other: each from the step in which this
/// is so for the first time until none of the features that were let go since is through anything. So a pair that
/// stays tangled is new once. Bodies that are gone, or have other faces, are none any more.
class LetGoPairs {
 public:
  /// Before add(), when the mirror has the bodies as they are in this step.
  void begin_step(const WorldMirror& mirror, const WorldKind& kind);
  void add(const MemberContact& found);
  /// "soft bodies 0 and 3, 2 within itself" of those that are new in this step, by their numbers in `bodies`. Empty
  /// where none are.
  std::string describe_new(const WorldMirror& mirror, Span<btSoftBody* const> bodies) const;

 private:
  struct Features {
    std::vector<Contact> contacts;
    bool is_new = true;
  };

  std::map<std::pair<std::uint32_t, std::uint32_t>, Features> pairs_;  ///< by the bodies' ids, the smaller one first
};

}  // namespace softcd::bullet
