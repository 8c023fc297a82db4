#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "brute_force.hpp"
#include "scene_geometry.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {

/// Returns the text of the error that `call` throws.
template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no exception";
}

/// Returns half the longest side of the box around both ends of every finite vertex.
inline double half_extent_of(const Scene& scene) {
  double low = INFINITY;
  double high = -INFINITY;
  double half = 0.0;
  for (int axis = 0; axis < 3; ++axis, low = INFINITY, high = -INFINITY) {
    for (const SceneBody& body : scene) {
      for (const Positions3* x : {&body.x_t0, &body.x_t1}) {
        for (const Vec3d& p : *x) {
          if (!std::isfinite(p[axis])) continue;
          low = std::min(low, p[axis]);
          high = std::max(high, p[axis]);
        }
      }
    }
    half = std::max(half, 0.5 * (high - low));
  }
  return half;
}

/// Expects contacts to ascend strictly in the order that detect() documents, hence each contact once.
inline void expect_sorted(const std::vector<Contact>& contacts) {
  for (std::size_t i = 1; i < contacts.size(); ++i) {
    ASSERT_LT(features_of(contacts[i - 1]), features_of(contacts[i])) << "at contact " << i;
  }
}

inline void expect_flawless(const Scene& scene, const std::vector<Contact>& contacts, Detection detection,
                            double tolerance) {
  const SceneGeometry geometry(scene);
  for (const Contact& contact : contacts) {
    const std::string flaw = geometry.flaw_of(contact, detection, tolerance);
    ASSERT_TRUE(flaw.empty()) << flaw;
  }
}

/// Returns the error of a float32 distance between points of the scene with float32 weights.
inline double point_tolerance(const Scene& scene) {
  return 1e-6 * half_extent_of(scene);
}

/// Expects the detector's contacts at t1 to be those of brute force. Returns their number.
inline std::size_t expect_discrete_contacts(const Scene& scene, const PipelineOptions& options,
                                            const DiscreteRules& rules = {}) {
  const std::vector<Contact> contacts = detect_once(scene, options, rules.pair_filter);
  const Difference difference = compare(discrete_verdicts(scene, rules), features_of(contacts));
  EXPECT_TRUE(agrees(difference)) << describe(difference);
  expect_sorted(contacts);
  expect_flawless(scene, contacts, Detection::dcd, point_tolerance(scene));
  return contacts.size();
}

/// Expects every pair that touches during the step to be reported. Other reported pairs must pass within `touching` or,
/// by default, 1e-9 of the scene's half extent. Returns the number of reported pairs.
inline std::size_t expect_continuous_contacts(const Scene& scene, const PipelineOptions& options,
                                              const PairFilter& pair_filter = {}, double touching = 0.0) {
  const std::vector<Contact> contacts = detect_once(scene, options, pair_filter);
  Difference difference = compare(continuous_verdicts(scene, pair_filter), features_of(contacts));
  const SceneGeometry geometry(scene);
  if (!(touching > 0.0)) touching = 1e-9 * half_extent_of(scene);
  std::erase_if(difference.extra, [&](const FeaturePair& pair) {
    const auto contact = std::find_if(contacts.begin(), contacts.end(),
                                      [&](const Contact& candidate) { return features_of(candidate) == pair; });
    return geometry.distance_near(pair, contact->time_of_impact) <= touching;
  });
  EXPECT_TRUE(agrees(difference)) << describe(difference);
  expect_sorted(contacts);
  expect_flawless(scene, contacts, Detection::ccd, point_tolerance(scene));
  return contacts.size();
}

/// Compares `contacts` of a continuous detection with margins with discrete detections at nine times of the step. These
/// must find nothing that `contacts` lack or report later. Returns how many of their pairs are not in `other`, which is
/// sorted.
inline std::size_t expect_nothing_missed_on_the_way(const Scene& scene, const std::vector<Contact>& contacts,
                                                    const std::vector<FeaturePair>& other = {}) {
  std::map<FeaturePair, float> times;
  for (const Contact& contact : contacts) times[features_of(contact)] = contact.time_of_impact;
  const double rounding = 0x1p-22 * half_extent_of(scene);
  std::size_t not_in_other = 0;
  constexpr int kSteps = 8;
  for (int step = 0; step <= kSteps; ++step) {
    const double t = double(step) / kSteps;
    Scene now = scene;
    for (SceneBody& body : now) {
      for (std::size_t v = 0; v < body.x_t0.size(); ++v) body.x_t1[v] = lerp(body.x_t0[v], body.x_t1[v], t);
      // Positions on the path are rounded.
      body.settings.margin = std::max(0.0F, body.settings.margin - static_cast<float>(rounding));
    }
    for (const FeaturePair& pair : features_of(detect_once(now, test_options(Detection::dcd)))) {
      const auto found = times.find(pair);
      if (found == times.end() || found->second > t + 1e-6) {
        ADD_FAILURE() << pair << (found == times.end() ? " is missed at " : " is late at ") << t;
        return not_in_other;
      }
      not_in_other += !std::binary_search(other.begin(), other.end(), pair);
    }
  }
  return not_in_other;
}

}  // namespace softcd::test
