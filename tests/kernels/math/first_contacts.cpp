#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>

#include "exact_ccd.hpp"
#include "queries.hpp"
#include "softcd/math/impact/impact.hpp"

// Compares times of impact with brackets of the exact ones, on 100,000 queries.
namespace softcd::test {
namespace {

constexpr std::array kKinds{ContactKind::vertex_triangle, ContactKind::edge_edge};
constexpr int kCount = 5'600;  // of each family and kind

struct Tally {
  int missed = 0;
  int false_alarms = 0;
  int late = 0;
  double latest = 0.0;
  double earliest = 0.0;

  /// Prints the first query of each kind of relevant error.
  template <class T>
  void add(const Query& query, const std::optional<TimeBracket>& truth, const Impact<T>& impact) {
    if (impact.state == ImpactState::separated) {
      if (truth && missed++ == 0) std::printf("missed: %s", to_string(query).c_str());
      return;
    }
    if (!truth) {
      ++false_alarms;
      return;
    }
    const auto time = static_cast<double>(impact.time);
    if (time > truth->hi && late++ == 0) std::printf("late by %g: %s", time - truth->hi, to_string(query).c_str());
    latest = std::max(latest, time - truth->hi);
    earliest = std::max(earliest, truth->lo - time);
  }

  void print(const char* mode, ContactKind kind, Family family, int touching) const {
    std::printf("%-12s %s %-12s %5d touch, %d missed, %5d false alarms, %d late by up to %.1e, early by up to %.1e\n",
                mode, kind == ContactKind::vertex_triangle ? "VT" : "EE", name_of(family), touching, missed,
                false_alarms, late, latest, earliest);
  }
};

class FirstContacts : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  Family family() const { return static_cast<Family>(GetParam()); }
};

TEST_P(FirstContacts, are_missed_by_no_mode_and_never_reported_late) {
  for (const ContactKind kind : kKinds) {
    Random random(GetParam() + 301);
    Tally fast, precise, conservative;
    int touching = 0;
    for (int i = 0; i < kCount; ++i) {
      const Query query = make_query(random, kind, family(), true);
      const std::optional<TimeBracket> truth = first_contact(query);
      touching += truth ? 1 : 0;
      fast.add(query, truth, impact_of<float>(query, 0.0F));
      precise.add(query, truth, impact_of<double>(query, 0.0));
      conservative.add(query, truth, approach_of(query, 0.0));
    }
    fast.print("fast", kind, family(), touching);
    precise.print("precise", kind, family(), touching);
    conservative.print("conservative", kind, family(), touching);
    EXPECT_GT(touching, 0);
    EXPECT_EQ(fast.missed, 0);
    EXPECT_EQ(precise.missed, 0);
    EXPECT_EQ(precise.late, 0);
    EXPECT_EQ(conservative.missed, 0);
    EXPECT_EQ(conservative.late, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Families, FirstContacts, ::testing::Range(0u, kFamilies),
                         [](const auto& suite) { return name_of(static_cast<Family>(suite.param)); });

}  // namespace
}  // namespace softcd::test
