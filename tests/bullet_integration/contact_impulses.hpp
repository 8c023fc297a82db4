#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "any_simulation.hpp"

/// For tests of the impulses of body_contacts().
namespace softcd::test {

inline constexpr btScalar kGravity = 10;

inline bullet::Settings reading_impulses(bullet::EdgeContacts edges = bullet::EdgeContacts::off) {
  bullet::Settings settings = test_settings();
  settings.read_out = bullet::ReadOut::impulses;
  settings.edge_contacts = edges;
  return settings;
}

/// With `has_crossings` the last pass of the step may have given a pair more than its contacts did.
inline btVector3 given_to(const btCollisionObject& body, const std::vector<bullet::BodyPairContacts>& pairs,
                          bool has_crossings = false) {
  btVector3 sum(0, 0, 0);
  for (const bullet::BodyPairContacts& pair : pairs) {
    EXPECT_TRUE(pair.has_impulses || pair.contacts.empty());
    btVector3 on_a(0, 0, 0), on_b(0, 0, 0);
    for (const bullet::BodyContact& contact : pair.contacts) {
      on_a += contact.impulse_a;
      on_b += contact.impulse_b;
    }
    if (!has_crossings) {
      EXPECT_NEAR(on_a.distance(pair.impulse_a), 0, 1e-5 * (1 + double(on_a.length())));
      EXPECT_NEAR(on_b.distance(pair.impulse_b), 0, 1e-5 * (1 + double(on_b.length())));
    }
    if (pair.a == &body) sum += pair.impulse_a;
    if (pair.b == &body) sum += pair.impulse_b;
  }
  return sum;
}

}  // namespace softcd::test
