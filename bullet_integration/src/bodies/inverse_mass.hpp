#pragma once

#include "LinearMath/btMinMax.h"

namespace softcd::bullet {

/// The effective inverse mass of two points in contact: the sum of weight^2 * inverse mass over their nodes, but at
/// least a tenth of the lightest node's inverse mass. If only nodes with small weights can move, the full response
/// would throw them (by 1 / weight, unbounded for a weight of 0). With the lower bound they give way gradually.
class ContactInverseMass {
 public:
  void add(btScalar weight, btScalar node_inverse_mass) {
    sum_ += weight * weight * node_inverse_mass;
    least_ = btMax(least_, kLeastShare * node_inverse_mass);
  }
  btScalar value() const { return btMax(sum_, least_); }

 private:
  static constexpr btScalar kLeastShare = btScalar(0.1);

  btScalar sum_ = 0;
  btScalar least_ = 0;
};

}  // namespace softcd::bullet
