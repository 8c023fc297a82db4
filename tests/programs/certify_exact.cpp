// The exact arithmetic of softcd-certify.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "exact_motion.hpp"
#include "mesh_sequence.hpp"
#include "mesh_tools/triangle_meeting.hpp"
#include "queries.hpp"
#include "sha256.hpp"

namespace softcd::test {
namespace {

using demo::certainly_pass_through;
using mesh_tools::Face;
using mesh_tools::Meeting;
using mesh_tools::meeting_of;

bool passes_through(const Query& query, double nearby) {
  const auto& r = query.rows;
  return certainly_pass_through(query.kind, {r[0], r[1], r[2], r[3]}, {r[4], r[5], r[6], r[7]}, nearby);
}

TEST(CertifyExact, only_features_that_touch_pass_through_each_other) {
  Random random(1);
  for (std::uint32_t family = 0; family < kFamilies; ++family) {
    for (int i = 0; i < 200; ++i) {
      const ContactKind kind = i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge;
      const Query query = make_query(random, kind, Family{family}, false);
      const auto touch = first_contact(query);
      const double nearby = touch ? touch->lo : random.unit();
      if (passes_through(query, nearby)) {
        EXPECT_TRUE(touch.has_value()) << name_of(Family{family}) << ' ' << i;
      }
    }
  }
}

TEST(CertifyExact, proves_clean_crossings_at_their_times_and_not_at_others) {
  Random random(2);
  int touching = 0;
  int proved = 0;
  for (int i = 0; i < 2000; ++i) {
    const ContactKind kind = i % 2 == 0 ? ContactKind::vertex_triangle : ContactKind::edge_edge;
    const Query query = make_query(random, kind, Family::random, false);
    const auto touch = first_contact(query);
    if (!touch) continue;
    ++touching;
    proved += passes_through(query, static_cast<double>(static_cast<float>(touch->lo))) ? 1 : 0;
  }
  EXPECT_GT(touching, 200);
  EXPECT_GT(proved, touching * 99 / 100);
}

// A vertex falls onto a triangle and through it, from 1 above to `end`.
bool falls_through(double x, double y, double end, double scale) {
  const demo::PairPositions x_t0 = {scale * Vec3d{x, y, 1}, {0, 0, 0}, scale * Vec3d{4, 0, 0}, scale * Vec3d{0, 4, 0}};
  demo::PairPositions x_t1 = x_t0;
  x_t1[0] = scale * Vec3d{x, y, end};
  return certainly_pass_through(ContactKind::vertex_triangle, x_t0, x_t1, 1 / (1 - end));
}

TEST(CertifyExact, a_vertex_on_the_border_or_that_stops_in_the_plane_does_not_pass_through) {
  for (const double scale : {1.0, 1e-300, 1e30, std::numeric_limits<double>::denorm_min()}) {
    EXPECT_TRUE(falls_through(1, 1, -1, scale));
    EXPECT_FALSE(falls_through(1, 1, 0, scale)) << "it stops in the plane";
    EXPECT_FALSE(falls_through(2, 2, -1, scale)) << "through an edge";
    EXPECT_FALSE(falls_through(0, 0, -1, scale)) << "through a corner";
    EXPECT_FALSE(falls_through(3, 3, -1, scale)) << "beside it";
  }
  EXPECT_TRUE(falls_through(1, 1, -0x1p-40, 1));
}

TEST(CertifyExact, tells_triangles_that_touch_from_those_that_are_through_each_other) {
  const Face ground = {{0, 1, 2}, {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}}};
  const auto standing_at = [](double z) { return Face{{3, 4, 5}, {{{1, 1, z}, {1, 1.5, 8}, {1.5, 1, 8}}}}; };
  EXPECT_EQ(meeting_of(ground, standing_at(1e-300)), Meeting::apart);
  EXPECT_EQ(meeting_of(ground, standing_at(0)), Meeting::touching);
  EXPECT_EQ(meeting_of(ground, standing_at(-1e-300)), Meeting::through);
  EXPECT_EQ(meeting_of(standing_at(-1e-300), ground), Meeting::through);
  EXPECT_EQ(meeting_of(ground, {{3, 4, 5}, ground.x}), Meeting::touching) << "the same place";
}

TEST(CertifyExact, neighbours_meet_only_beside_what_they_share) {
  const Face ground = {{0, 1, 2}, {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}}};
  const Face folded = {{0, 1, 3}, {{{0, 0, 0}, {4, 0, 0}, {1, 1, 0}}}};
  EXPECT_EQ(meeting_of(ground, folded), Meeting::apart) << "they share an edge";
  const Face fan = {{0, 3, 4}, {{{0, 0, 0}, {-1, -1, 0}, {-1, -2, 0}}}};
  EXPECT_EQ(meeting_of(ground, fan), Meeting::apart) << "they share a corner";
  const Face through = {{0, 3, 4}, {{{0, 0, 0}, {1, 1, 1}, {1, 1, -1}}}};
  EXPECT_EQ(meeting_of(ground, through), Meeting::through);
}

TEST(CertifyExact, frames_are_sorted_by_their_numbers) {
  EXPECT_TRUE(demo::is_before("frame9.ply", "frame10.ply"));
  EXPECT_FALSE(demo::is_before("frame10.ply", "frame9.ply"));
  EXPECT_TRUE(demo::is_before("frame-0009.ply", "frame-0010.ply"));
  EXPECT_TRUE(demo::is_before("frame9.ply", "frame9b.ply") != demo::is_before("frame9b.ply", "frame9.ply"));
  EXPECT_TRUE(demo::is_before("a01.ply", "a1.ply") != demo::is_before("a1.ply", "a01.ply"));
  EXPECT_FALSE(demo::is_before("a1.ply", "a1.ply"));
  EXPECT_TRUE(demo::is_before("a99999999999999999999998", "a99999999999999999999999"));
  EXPECT_TRUE(demo::is_before("a", "b1"));
}

// Digests of FIPS 180-2, appendix B.
TEST(CertifyExact, hashes_are_those_of_the_standard) {
  EXPECT_EQ(demo::sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(demo::sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace softcd::test
