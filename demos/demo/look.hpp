#pragma once

#include "softcd/core/vec3.hpp"

/// Light and colours (linear, 0 to 1) of pictures and of the viewer.
namespace softcd::demo {

constexpr Vec3d kTowardsSun = {0.45, 1.0, 0.35};  ///< of any length
constexpr double kAmbient = 0.34;
constexpr double kSun = 0.85;
constexpr double kGloss = 0.12;
constexpr double kGlossExponent = 24;
constexpr double kShadowBias = 0.02;  ///< of the scene's unit
constexpr double kFloorReach = 60;    ///< how far away the floor has faded into the haze
constexpr Vec3f kFloorLight{0.48F, 0.49F, 0.50F};
constexpr Vec3f kFloorDark{0.40F, 0.41F, 0.43F};
constexpr Vec3f kHorizon{0.78F, 0.82F, 0.86F};
constexpr Vec3f kZenith{0.42F, 0.55F, 0.70F};
constexpr float kGamma = 2.2F;

}  // namespace softcd::demo
