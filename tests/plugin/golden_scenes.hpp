#pragma once

#include "scene.hpp"

namespace softcd::test {

/// A small scene that is the same on every machine, because it is made with + - * / and square roots only.
struct GoldenScene {
  const char* name;
  Scene (*make)();
};

Scene soups();
/// Positions are not floats.
Scene roughened_soups();
/// So far from the origin that the scene's origin is shifted.
Scene distant_soups();
/// Some vertices are not finite, at one end of the step or the other.
Scene strays();
Scene tiny_soups();
Scene huge_soups();
Scene needles();
Scene degenerate_triangles();
/// Triangles that are split, among many that are not.
Scene uneven_soups();
Scene ball_through_sheets();
/// A ball that passes through itself on its path.
Scene everted_ball();
/// Three times the same ball in the same place, which does not move.
Scene coincident_balls();
/// All triangles of two sheets lie in one plane, in which they move.
Scene coplanar_sheets();
Scene accordion();
/// A turn by the angle of a 3-4-5 triangle, along straight lines.
Scene turning_stars();
/// All triangles of each body share a vertex.
Scene hubs();
/// Groups, masks and kinds of features that leave some pairs out.
Scene filtered_soups();
Scene kinematic_ground();
/// A coarse body whose margin is many of a fine one's edges.
Scene unequal_margins();
/// Nothing but points and segments.
Scene points_and_segments();
/// Links without faces: a rope through a cloth that has fringes.
Scene rope_and_fringes();

}  // namespace softcd::test
