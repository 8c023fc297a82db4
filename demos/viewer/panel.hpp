#pragma once

#include <optional>
#include <string>

#include "viewer/overlays.hpp"
#include "viewer/session.hpp"

namespace softcd::demo {

/// A face of one of the scene's bodies.
struct SelectedFace {
  std::size_t body;
  int face;
};

/// The panel's content besides the session, and the settings that the user can change.
struct PanelState {
  bool is_visible = true;
  bool is_paused = false;
  int steps_per_frame = 2;  ///< 120 steps a second: as fast as reality at 60 frames a second
  OverlayChoice overlays;
  std::optional<SelectedFace> selected;
  std::string problem;        ///< why the last change of the scene or the detection failed; empty when it did not
  std::string saved_picture;  ///< the file of the last picture; empty before

  /// Penetrations, counted on demand at that simulated time.
  struct Penetrating {
    std::size_t vertices;
    double time;
  };
  std::optional<Penetrating> penetrating;

  // Requests of this frame:
  bool step_once = false;
  bool restart = false;
  bool reset_view = false;
  bool throw_ball = false;
  bool save_picture = false;
  std::optional<SceneOptions> go_on_with;
  std::optional<std::string> open_scene;
};

constexpr int kPanelWidth = 340;  ///< pixels, at the left of the window

/// Draws the panel, within a frame of Dear ImGui. `grid` may be null.
void draw_panel(const Session& session, const DetectionGrid* grid, PanelState& state);

}  // namespace softcd::demo
