#pragma once

#include <cmath>
#include <cstdint>

#include "softcd/core/vec3.hpp"

namespace softcd::test {

/// A seeded generator whose values are the same with every standard library (std's distributions are not).
/// SplitMix64, Steele, Lea, Flood 2014.
class Random {
 public:
  explicit Random(std::uint64_t start) : state_(start) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }

  /// Returns a number in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(bits() % count); }
  bool chance(double probability) { return unit() < probability; }
  Vec3d in_box(double half_size) {
    const double x = uniform(-half_size, half_size);
    const double y = uniform(-half_size, half_size);
    const double z = uniform(-half_size, half_size);
    return {x, y, z};
  }

  /// Returns a direction, uniform on the unit sphere.
  Vec3d direction() {
    while (true) {
      const Vec3d p = in_box(1.0);
      const double squared = squared_norm(p);
      if (squared > 1e-4 && squared <= 1.0) return (1.0 / std::sqrt(squared)) * p;
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace softcd::test
