#pragma once

#include "softcd/core/vec3.hpp"

/// Light and colours (linear, 0 to 1) of pictures and of the window.
namespace softcd::demo {

constexpr Vec3d kTowardsSun = {0.45, 1.0, 0.35};  ///< need not have the length 1
constexpr double kAmbient = 0.34;
constexpr double kSun = 0.85;
constexpr double kGloss = 0.12;
constexpr double kGlossExponent = 24;
constexpr double kShadowBias = 0.02;           ///< in the scene's unit, as are the next two
constexpr double kSharpestShadowEdge = 0.012;  ///< half the width of a shadow's edge, at least
constexpr double kWidestShadowEdge = 0.14;     ///< half the width of a shadow's edge, at most
constexpr double kSunRadius = 0.07;            ///< at distance 1
constexpr double kSteepestSlope = 2;           ///< limit of the slope that the bias grows with
constexpr int kBlockerSamples = 12;
constexpr int kShadowSamples = 28;
constexpr double kEdgeWidth = 1;  ///< of triangles, in pixels
constexpr double kEdgeShade = 0.5;
constexpr double kFloorReach = 60;  ///< how far away the floor has faded into the haze
constexpr Vec3f kFloorLight{0.48F, 0.49F, 0.50F};
constexpr Vec3f kFloorDark{0.40F, 0.41F, 0.43F};
constexpr Vec3f kHorizon{0.78F, 0.82F, 0.86F};
constexpr Vec3f kZenith{0.42F, 0.55F, 0.70F};
constexpr float kGamma = 2.2F;

}  // namespace softcd::demo
