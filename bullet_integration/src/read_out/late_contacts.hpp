#pragma once

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
  void clear() { bodies_.clear(); }
  /// Finds the bodies to solve again. Call it right before Bullet's solver, when all contacts are in the arrays.
  /// `bodies` are the world's, in the solver's order. Throws std::bad_alloc, and solve() then does nothing.
  void find(Span<btSoftBody* const> bodies);
  /// Solves the contacts. Call it once, after Bullet's solver. `bodies` are the world's. Leaves out bodies that touch
  /// one which is gone or has new nodes or faces. Adds the impulses to `impulses` for bodies whose solver impulses are
  /// known there, unless it is null.
  void solve(Span<btSoftBody* const> bodies, ContactImpulses* impulses);

 private:
  struct Body {
    btSoftBody* body;
    const btSoftBody::Node* nodes;  ///< where the contacts refer to; the body may have others when solve() is called
    const btSoftBody::Face* faces;
    std::vector<std::uint32_t> touched = {};  ///< places in bodies_, ascending
    std::vector<std::uint32_t> others = {};   ///< the place of each contact's other body
    bool is_pushed_late = false;              ///< whether to solve its contacts again
    bool is_moved = false;                    ///< by solve()
  };

  bool is_pushed_late(std::uint32_t one, std::uint32_t other) const;
  void solve(const Body& owner, ContactImpulses* impulses) const;

  std::vector<Body> bodies_;
};

}  // namespace softcd::bullet
