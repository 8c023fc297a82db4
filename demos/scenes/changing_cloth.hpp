#pragma once

#include <utility>
#include <vector>

#include "scenes/scene.hpp"

namespace softcd::demo {

/// The initial state of such a scene.
struct ClothAndBall {
  btScalar side;            ///< of the cloth
  btScalar height;          ///< of the cloth, whose middle is on the y axis
  bool is_held_at_corners;  ///< else not at all
  btVector3 ball_center;
  btScalar ball_radius;
};

/// A cloth whose nodes, links and faces change every few steps, and a ball that moves as its nodes' velocities say.
class ChangingCloth : public Scene {
 public:
  std::vector<Surface> surfaces() const override;

 protected:
  /// Two nodes that a link joins.
  using Edge = std::pair<int, int>;

  ChangingCloth(const SceneOptions& options, const ClothAndBall& shape);

  void animate() override;
  /// Returns the edges at which the cloth is to be changed now.
  virtual std::vector<Edge> edges_to_change() const = 0;
  /// Changes the cloth at this edge; new nodes are in its middle. Returns false where that is impossible.
  virtual bool change_at(const Edge& edge) = 0;
  void repeat_changes(const Scene& other) override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

  btSoftBody& cloth() const { return *cloth_; }
  btSoftBody& ball() const { return *ball_; }
  btScalar spacing() const { return spacing_; }

 private:
  void change(const Edge& edge);
  void restore_lengths_at_rest();

  btSoftBody* cloth_;
  btSoftBody* ball_;
  btScalar spacing_;                ///< of the cloth's nodes before it changes
  std::vector<btVector3> at_rest_;  ///< the cloth's nodes
  std::vector<Edge> changed_;       ///< in the order of the changes
  int step_ = 0;
};

}  // namespace softcd::demo
