#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// The reason why a pair of bodies intersects.
enum class TangleReason : std::uint8_t {
  start,        ///< the bodies intersected at the start of a step and were released
  unavoidable,  ///< the app has moved one body through the other
};

/// Pairs of bodies with tangled features. A pair is new once, for one reason, until it has separated. Owned by
/// CrossingPrevention.
class TangledPairs {
 public:
  /// Begins a step. Call it before add().
  void begin_step();
  void add(const Contact& found, TangleReason reason);
  /// Describes the pairs that are new in this step for this reason, such as "soft bodies 0 and 3, 2 within itself".
  /// Numbers are indices in `bodies`; other bodies are named as rigid meshes. Returns an empty text if there are none.
  std::string describe_new(TangleReason reason, const WorldMirror& mirror, Span<btSoftBody* const> bodies) const;

 private:
  struct Pair {
    TangleReason reason;
    std::uint64_t first_step, last_step;  ///< in which it was added
  };

  std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> pairs_;  ///< by the bodies' ids, smaller id first
  std::uint64_t step_ = 0;
};

}  // namespace softcd::bullet
