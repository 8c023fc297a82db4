#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.hpp"
#include "viewer/detection_grid.hpp"

namespace softcd::demo {

/// The last values of a quantity that is measured in every step, the newest at the end.
class History {
 public:
  static constexpr std::size_t kLength = 240;

  void add(float value);
  const std::vector<float>& values() const { return values_; }
  float last() const { return values_.empty() ? 0.0F : values_.back(); }

 private:
  std::vector<float> values_;
};

/// A running scene, which can be restarted, or continued with other options.
class Session {
 public:
  /// Throws the exceptions of make_scene.
  Session(std::string scene_name, const SceneOptions& options);

  const std::string& scene_name() const { return scene_name_; }
  const SceneOptions& options() const { return options_; }
  const Scene& scene() const { return *scene_; }
  const std::vector<btSoftBody*>& bodies() const { return bodies_; }

  void step();
  void restart();
  /// Opens another scene at its default size, with otherwise the same options. Throws the exceptions of make_scene;
  /// nothing is then changed.
  void open(const std::string& scene_name);
  void throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity);
  /// Continues with the same positions and velocities in a new world. Throws the exceptions of make_scene; nothing is
  /// then changed.
  void go_on_with(const SceneOptions& options);

  const History& step_ms() const { return step_ms_; }
  /// Sets whether body_contacts() is filled from the next step on.
  void set_reads_contacts(bool reads_contacts) { reads_contacts_ = reads_contacts; }
  /// Returns the contacts of the last step. Empty where Bullet detects, or unless they are read.
  const std::vector<bullet::BodyPairContacts>& body_contacts() const { return body_contacts_; }

  /// Returns the times of softcd's detector. They stay unchanged while Bullet detects.
  const History& detection_ms() const { return detection_ms_; }

  /// Returns the grid around the last step's final motion, after the contacts were solved. The detector saw the motion
  /// before that. Null where Bullet detects.
  std::unique_ptr<DetectionGrid> make_grid() const;

 private:
  void adopt(std::unique_ptr<Scene> scene);

  std::string scene_name_;
  SceneOptions options_;
  std::unique_ptr<Scene> scene_;
  std::vector<btSoftBody*> bodies_;
  std::vector<bullet::BodyPairContacts> body_contacts_;
  bool reads_contacts_ = false;
  History step_ms_, detection_ms_;
};

}  // namespace softcd::demo
