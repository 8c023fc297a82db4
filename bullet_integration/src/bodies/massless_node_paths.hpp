#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bodies/body_key.hpp"
#include "bodies/node_ends.hpp"

namespace softcd::bullet {

/// The paths of massless nodes that the app moves by m_x, in classic worlds. Bullet's prediction begins a node's path
/// where the app has put the node. So the move itself would be part of no step, and features could already intersect
/// when the path begins. Here the path begins where the last step ended: m_q goes back there. In the step the node has
/// the velocity of its path, as if the app had moved it by m_v. Afterwards it has its own velocity again.
///
/// If free nodes of the body have moved as well, or if a node has moved by more than the body's size, the app has
/// placed the body anew. Such a move is no path. Owned by WorldQueries.
class MasslessNodePaths {
 public:
  /// Call it before Bullet's prediction. An exception may have left the last step before end_step().
  void begin_step(Span<btSoftBody* const> bodies);
  /// Begins the paths of moved nodes where the last step ended. Call it after Bullet's prediction, before anything
  /// reads the nodes' paths. Does nothing outside of a step. Takes no memory.
  void set_starts(Span<btSoftBody* const> bodies);
  /// Gives the nodes their own velocities back. Call it after all responses.
  void give_velocities_back(Span<btSoftBody* const> bodies);
  /// Undoes set_starts(), for a step whose end this class will not see.
  void take_starts_back(Span<btSoftBody* const> bodies);
  /// Remembers where the nodes are. If it throws, it has forgotten all nodes.
  void end_step(Span<btSoftBody* const> bodies);

 private:
  struct Lent {
    int node;
    btVector3 place;     ///< m_q as the app and Bullet have it
    btVector3 velocity;  ///< the node's own
  };
  struct Track {
    std::vector<btVector3> ends;  ///< of all nodes, in the last step
    std::vector<Lent> lent;       ///< in this step
    bool is_present = false;      ///< in end_step()
  };

  Track* find(const btSoftBody& body);
  static bool has_moved_massless_nodes_alone(const btSoftBody& body, const Track& track);

  std::unordered_map<BodyKey, Track, BodyKeyHash> tracks_;  ///< of bodies with massless nodes
  bool are_ends_known_ = false;                             ///< from here to set_starts()
  bool has_begun_ = false;                                  ///< the step, whose set_starts() is to come
  bool has_lent_ = false;
};

}  // namespace softcd::bullet
