#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "softcd/bullet/body_contacts.hpp"

namespace softcd::bullet::pybullet {

/// Adds up the impulses of each pair of bodies over several steps, by PyBullet's ids: PyBullet may make several steps
/// in one stepSimulation.
class ImpulseSums {
 public:
  /// Adds a step's contacts. `step_length` is in seconds. Throws nothing: after a step that had too little memory all
  /// sums are unknown.
  void add(const std::vector<BodyPairContacts>& pairs, double step_length) noexcept;
  /// Returns the seconds since the last call as a double, and a struct for each pair. Clears the sums.
  std::string take();

 private:
  struct Sum {
    std::array<double, 3> on_a{}, on_b{};
  };

  void add_pair(const BodyPairContacts& pair);

  std::map<std::array<std::int32_t, 4>, Sum> sums_;  ///< by bodies and links
  double seconds_ = 0;
  bool has_failed_ = false;
};

}  // namespace softcd::bullet::pybullet
