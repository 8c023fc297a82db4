#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.hpp"
#include "viewer/detection_grid.hpp"

namespace softcd::demo {

/// The last values of something that is measured in every step, the newest at the end.
class History {
 public:
  static constexpr std::size_t kLength = 240;

  void add(float value);
  const std::vector<float>& values() const { return values_; }
  float last() const { return values_.empty() ? 0.0F : values_.back(); }

 private:
  std::vector<float> values_;
};

/// A scene that runs, can begin again, and can go on under other options.
class Session {
 public:
  /// Throws as make_scene.
  Session(std::string scene_name, const SceneOptions& options);

  const std::string& scene_name() const { return scene_name_; }
  const SceneOptions& options() const { return options_; }
  const Scene& scene() const { return *scene_; }
  const std::vector<btSoftBody*>& bodies() const { return bodies_; }

  void step();
  void restart();
  /// Another scene, at its default size, with the same options else. Throws as make_scene; nothing has changed then.
  void open(const std::string& scene_name);
  void throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity);
  /// The same positions and velocities in a new world. Throws as make_scene; nothing has changed then.
  void go_on_with(const SceneOptions& options);

  const History& step_ms() const { return step_ms_; }
  /// From the next step on, whether body_contacts() is read.
  void set_reads_contacts(bool reads_contacts) { reads_contacts_ = reads_contacts; }
  /// The contacts of the last step. Empty where Bullet detects, and unless they are read.
  const std::vector<bullet::BodyPairContacts>& body_contacts() const { return body_contacts_; }

  /// Of softcd's detector; stands still where Bullet detects.
  const History& detection_ms() const { return detection_ms_; }

  /// The grid around the last step's motion as it came out, contacts solved: the detector saw the motion before that.
  /// Of softcd only: null where Bullet detects.
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
