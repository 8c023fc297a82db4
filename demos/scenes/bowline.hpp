#pragma once

#include <optional>

#include "scenes/ribbon.hpp"
#include "scenes/scene.hpp"

namespace softcd::demo {

/// A weightless ribbon whose loop round a post is closed by a loose bowline. A hand pulls at its standing part until
/// that is taut. The other end is free: without contacts within the ribbon the knot comes undone.
class Bowline : public Scene {
 public:
  explicit Bowline(const SceneOptions& options);

  std::vector<Surface> surfaces() const override;
  View view() const override;

  /// Returns the position along the pull, the x axis.
  btScalar standing_end() const;
  btScalar free_end() const;
  /// Returns the stretch of the standing part.
  btScalar stretch() const { return standing_part_->stretch(); }

 protected:
  void animate() override;
  void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const override;

 private:
  int columns_;
  btSoftBody* ribbon_;
  btSoftBody* post_;
  std::optional<StretchGauge> standing_part_;
};

}  // namespace softcd::demo
