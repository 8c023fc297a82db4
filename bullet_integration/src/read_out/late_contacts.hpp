#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "read_out/contact_read_out.hpp"
#include "softcd/core/span.hpp"

namespace softcd::bullet {

/// Solves contacts between soft bodies once more at the end of a step in Bullet's classic worlds.
///
/// Bullet's solver finishes each body, with all its iterations, before it begins the next one. A later body pushes
/// bodies that it touches, and nothing then keeps these from being pushed through others that are finished, too. In a
/// pile nearly all crossings begin so, and each further iteration pushes again. Here the contacts of such bodies come
/// once more, those of the last body first. Velocities stay, as Bullet sets them before. Owned by WorldQueries.
class LateContacts {
 public:
  void clear() { count_ = 0; }
  /// Finds the bodies to solve again. Call it right before Bullet's solver, when all contacts are in the arrays.
  /// `bodies` are the world's, in the solver's order. Throws std::bad_alloc, and solve() then does nothing.
  void find(Span<btSoftBody* const> bodies);
  /// Solves the contacts. Call it once, after Bullet's solver. `bodies` are the world's. Leaves out bodies that touch
  /// one which is gone or has new nodes or faces. Adds the impulses to `impulses` for bodies whose solver impulses are
  /// known there, unless it is null.
  void solve(Span<btSoftBody* const> bodies, ContactImpulses* impulses);

 private:
  struct Body {
    btSoftBody* body = nullptr;
    /// The contacts refer to these nodes and faces; the body may have others when solve() is called.
    const btSoftBody::Node* nodes = nullptr;
    const btSoftBody::Face* faces = nullptr;
    std::vector<std::uint32_t> touched;  ///< places in bodies_, ascending
    std::vector<std::uint32_t> others;   ///< the place of each contact's other body
    bool is_pushed_late = false;         ///< whether to solve its contacts again
    bool is_moved = false;               ///< by solve()

    void reset(btSoftBody& of);
  };

  /// The place of each node's body.
  class NodeOwners {
   public:
    void reset(Span<btSoftBody* const> bodies);
    /// Returns kNoIndex for a node of no body. Contacts of the same bodies follow each other.
    std::uint32_t owner_of(const btSoftBody::Node* node);

   private:
    struct Range {
      const btSoftBody::Node *begin, *end;
      std::uint32_t owner;
      bool has(const btSoftBody::Node* node) const;
    };
    std::vector<Range> ranges_;  ///< by address
    std::size_t last_ = 0;
  };

  Span<Body> found() { return {bodies_.data(), count_}; }
  bool is_pushed_late(std::uint32_t one, std::uint32_t other) const;
  void solve(Body& owner, ContactImpulses* impulses);

  // Both keep their memory from step to step.
  std::vector<Body> bodies_;
  NodeOwners owners_;
  std::size_t count_ = 0;  ///< of the bodies that were found in this step, the first of bodies_
};

}  // namespace softcd::bullet
