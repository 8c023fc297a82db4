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

/// Pairs of bodies with tangled features. A pair stays from the first step in which it is tangled until none of the
/// features added since then is tangled. So a pair is new once, for one reason. Pairs with removed bodies are dropped.
/// If a body gets other faces, its pair is dropped unless new features are tangled in that step.
///
/// Bodies that part and meet in turn make a new pair each time. The pair is described when it is new for the first,
/// second, fourth, eighth time and so on, so that the log stays short. Owned by CrossingPrevention.
class TangledPairs {
 public:
  /// Begins a step. Call it before add(), when the mirror has the bodies of this step.
  void begin_step(const WorldMirror& mirror, const NodeEnds& ends);
  void add(const Contact& found, TangleReason reason);
  bool empty() const { return pairs_.empty(); }
  /// Describes the pairs that are new in this step for this reason, such as "soft bodies 0 and 3 (4 times so far), 2
  /// within itself".
  /// Numbers are indices in `bodies`; other bodies are named as rigid meshes. Returns an empty text if there are none.
  std::string describe_new(TangleReason reason, const WorldMirror& mirror, Span<btSoftBody* const> bodies) const;

 private:
  using Ids = std::pair<std::uint32_t, std::uint32_t>;  ///< of two bodies, smaller id first
  struct Features {
    TangleReason reason;
    std::uint32_t times;  ///< how often the bodies have been a new pair
    std::vector<Contact> contacts = {};
    bool is_new = true;
  };

  std::map<Ids, Features> pairs_;
  std::map<Ids, std::uint32_t> times_;  ///< how often two bodies of the mirror have been a new pair
};

}  // namespace softcd::bullet
