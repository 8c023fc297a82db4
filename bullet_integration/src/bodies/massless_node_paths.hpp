#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "bodies/body_key.hpp"
#include "bodies/node_ends.hpp"

namespace softcd::bullet {

/// The paths of massless nodes that the app moves by m_x. Bullet's prediction begins a node's path where the app has
/// put the node. So the move itself would be part of no step, and features could already intersect when the path
/// begins. Here the path begins where the last step ended: NodeEnds::start goes back there. In the step the node has
/// the velocity of its path, as if the app had moved it by m_v. Afterwards it has its own velocity again, and is
/// exactly where it would be without this class.
///
/// If m_q has changed as well, or if a node has moved by more than the body's size, the app has placed the body anew:
/// btSoftBody::transform() and apps that restore a state set both positions. Such a move is no path. Neither is a move
/// by more than Bullet's deformable solver moves a node in a step (m_maxDisplacement). Owned by WorldQueries.
class MasslessNodePaths {
 public:
  /// `ends` must outlive it.
  explicit MasslessNodePaths(const NodeEnds& ends) : ends_(ends) {}

  /// Begins a step. An exception may have left the last one before end_step().
  void begin_step(Span<btSoftBody* const> bodies);
  /// Finds the bodies whose nodes the app has moved. Call it right before Bullet's prediction.
  void find_moves(Span<btSoftBody* const> bodies);
  /// Begins the paths of moved nodes where the last step ended. Call it after Bullet's prediction, before anything
  /// reads the nodes' paths.
  void set_starts(Span<btSoftBody* const> bodies, btScalar time_step);
  /// Puts the ends of the body's paths, which are sums with the velocities of the paths, where the app wants them.
  void round_ends(btSoftBody& body) const;
  /// Gives the nodes their own velocities back. Call it after all responses, and where Bullet moves the nodes after
  /// them, when it has done so. If it has not, undoes set_starts().
  void end_paths(Span<btSoftBody* const> bodies);
  /// Undoes set_starts(), for a step whose end this class will not see.
  void take_starts_back(Span<btSoftBody* const> bodies);
  /// Remembers where the nodes are. If it throws, it has forgotten all nodes.
  void end_step(Span<btSoftBody* const> bodies);

 private:
  struct Path {
    int node = 0;
    btVector3 end = {};       ///< m_x when the last step ended
    btVector3 start = {};     ///< m_q then
    bool is_changed = false;  ///< by set_starts(), in this step
    // Without this class the node's path would have this start, end and velocity.
    btVector3 own_start = {};
    btVector3 own_end = {};
    btVector3 own_velocity = {};
  };
  struct Track {
    std::vector<Path> paths;  ///< of all massless nodes
    int node_count = 0;       ///< all of the body's
    bool has_moved = false;   ///< from find_moves() to set_starts()
    bool is_present = false;  ///< in end_step()
  };

  const Track* find(const btSoftBody& body) const;
  Track* find(const btSoftBody& body) { return const_cast<Track*>(std::as_const(*this).find(body)); }
  bool begins_at_nodes() const { return ends_.start == &btSoftBody::Node::m_x; }
  btScalar steps_per_second(const btSoftBody& body) const;
  btVector3 velocity_of(const Path& path, const btSoftBody& body) const;
  bool has_moved(const btSoftBody& body, const Track& track) const;

  const NodeEnds& ends_;
  std::unordered_map<BodyKey, Track, BodyKeyHash> tracks_;  ///< of bodies with massless nodes
  bool are_ends_known_ = false;                             ///< from end_step() to find_moves()
  bool has_moves_ = false;                                  ///< from find_moves() to set_starts()
  bool has_changes_ = false;
  btScalar time_step_ = 0;  ///< of the last set_starts() with moves
};

}  // namespace softcd::bullet
