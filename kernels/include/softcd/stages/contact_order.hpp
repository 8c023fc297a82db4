#pragma once

#include <cstdint>

#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/counting.hpp"

/// Puts found contacts in order: kind above first feature above second. One method sorts their keys. The other, for
/// contacts that are spread over the features, orders them in runs. A run has the contacts of nearby first features
/// side by side, and each contact counts those of its run that come before it.
namespace softcd {

/// Makes sort keys, in as few bits as the scene needs.
struct MakeContactKey {
  const FeatureContact* contacts;
  std::uint32_t first_bits;
  std::uint32_t second_bits;
  std::uint64_t* keys;
  std::uint32_t* order;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint64_t features = contacts[i].features;
    const auto kind = static_cast<std::uint64_t>(kind_of(features));
    keys[i] = (((kind << first_bits) | first_feature(features)) << second_bits) | second_feature(features);
    order[i] = i;
  }
};

/// Contacts in a run beyond which sorting is faster.
constexpr std::uint32_t kLongRun = 128;

/// The run of a contact, and its key there. The vertices' runs are before the edges'.
struct ContactRuns {
  std::uint32_t vertex_count;
  std::uint32_t shift;  ///< a run has 2^shift first features

  SOFTCD_HD std::uint64_t key(std::uint64_t features) const {
    const std::uint64_t before = kind_of(features) == ContactKind::vertex_triangle ? 0U : vertex_count;
    return ((before + first_feature(features)) << 32) | second_feature(features);
  }
  SOFTCD_HD std::uint64_t run(std::uint64_t key) const { return key >> 32 >> shift; }
};

/// The runs for at most this many contacts: up to twice as many runs and one, and no more than one for each feature and
/// one.
struct RunPlan {
  std::uint32_t shift;
  std::uint64_t run_count;
};
inline RunPlan plan_runs(std::uint64_t features, std::uint64_t contacts) {
  std::uint32_t shift = 0;
  while ((features >> shift) > 2 * contacts) ++shift;
  return {shift, (features >> shift) + 1};
}

/// Counts each contact in its run, and stores how many were there before it. `longs` counts runs that become too long.
struct CountInRun {
  ContactRuns runs;
  const FeatureContact* contacts;
  std::uint32_t* counts;
  std::uint32_t* places;

  template <class Longs>
  SOFTCD_HD void operator()(std::uint32_t i, Longs& longs) const {
    if (count(i, contacts[i].features)) longs.push(0U);
  }
  /// Returns whether the run has become too long.
  SOFTCD_HD bool count(std::uint64_t i, std::uint64_t features) const {
    const std::uint32_t place = count_one_more(counts + runs.run(runs.key(features)));
    places[i] = place;
    return place == kLongRun;
  }
};

/// Stores contacts, and counts each in its run at once. For backends whose lists do not grow while a stage runs.
struct RunTarget {
  using Value = FeatureContact;
  FeatureContact* contacts;
  CountInRun counter;  ///< counts nothing if its counts are null
  std::uint64_t* long_runs;

  SOFTCD_HD void store(std::uint64_t i, const FeatureContact& contact) const {
    contacts[i] = contact;
    if (counter.counts != nullptr && counter.count(i, contact.features)) count_one_more(long_runs);
  }
};

constexpr std::uint64_t kNoPlace = ~std::uint64_t{0};

struct LayIntoRun {
  ContactRuns runs;
  const FeatureContact* contacts;
  const std::uint64_t* begins;
  const std::uint32_t* places;
  std::uint64_t* keys;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint64_t key = runs.key(contacts[i].features);
    keys[begins[runs.run(key)] + places[i]] = key;
  }
};

/// Ranks the contacts of each run.
struct RankInRun {
  ContactRuns runs;
  const FeatureContact* contacts;
  const std::uint64_t* begins;
  const std::uint32_t* counts;
  const std::uint64_t* keys;

  /// Returns the place of a contact in the order of all; kNoPlace in a run that is too long: it will be sorted.
  SOFTCD_HD std::uint64_t place(std::uint32_t i) const {
    const std::uint64_t key = runs.key(contacts[i].features);
    const std::uint64_t run = runs.run(key);
    const std::uint64_t begin = begins[run];
    const std::uint32_t count = counts[run];
    if (count > kLongRun) return kNoPlace;
    std::uint32_t before = 0;
    for (std::uint32_t k = 0; k < count; ++k) before += keys[begin + k] < key ? 1U : 0U;
    return begin + before;
  }
};

}  // namespace softcd
