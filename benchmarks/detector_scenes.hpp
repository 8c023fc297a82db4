#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "command_line/choices.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct SceneBody {
  std::vector<Triangle> triangles;
  std::vector<Vec3f> x_t0, x_t1;
  BodySettings settings;
};

/// One step of several bodies.
struct DetectorScene {
  std::string name;
  double edge_length = 0;  ///< of its finer meshes; the unit of motions and distances
  std::vector<SceneBody> bodies;
  bool is_from_files = false;  ///< such a scene may have no contacts; the others must have some

  std::size_t triangle_count() const;
};

/// Returns a cloth in a funnel, half of it through, in folds that lie on each other and on the funnel. It moves down by
/// half an edge. 18K triangles at scale 1.
DetectorScene make_funnel(double scale);

/// Returns a cloth over a turning ball, in folds that lie on each other below the equator. 92K triangles at scale 1.
DetectorScene make_cloth_on_ball(double scale);

/// Returns 450 balls of 320 triangles each that move in all directions, around 4 cones of 10 triangles. A cone's
/// triangle is a thousand times as large as a ball's. 144K triangles at scale 1, which multiplies the number of bodies.
DetectorScene make_n_body(double scale);

/// Returns 1,024 cloths on balls of 1K triangles, all at one place, and each a batch. 1M triangles at scale 1, which
/// multiplies the number of batches.
DetectorScene make_batches(double scale);

/// Returns 1,000 boxes of 12 triangles each, spread so that few meet, which move by a tenth of an edge. 12K triangles
/// at scale 1, which multiplies the number of bodies.
DetectorScene make_many_bodies(double scale);

/// Reads two frames of one mesh, as one body that collides with itself. Throws mesh_tools::MeshError.
DetectorScene read_scene(const std::filesystem::path& t0, const std::filesystem::path& t1);

/// Reads the two meshes in frames/ of `step`; the scene has that folder's name. Throws mesh_tools::MeshError.
DetectorScene read_recorded_step(const std::filesystem::path& step);

using MakeScene = DetectorScene (*)(double scale);

/// The paper's benchmarks (section 4.1) for which a formula exists, and one for the number of bodies.
inline constexpr std::array<demo::Choice<MakeScene>, 5> kScenes = {{{"funnel", make_funnel},
                                                                    {"cloth-on-ball", make_cloth_on_ball},
                                                                    {"n-body", make_n_body},
                                                                    {"many-bodies", make_many_bodies},
                                                                    {"batches", make_batches}}};

}  // namespace softcd::benchmarks
