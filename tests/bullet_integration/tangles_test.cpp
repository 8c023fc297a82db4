// Bodies that already intersect at the start of a step.

#include "contacts/tangles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "mesh_tools/exact_intersection.hpp"
#include "random.hpp"
#include "scenes/penetration.hpp"
#include "soft_body_steps.hpp"
#include "soft_body_support.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::test {
namespace {

using bullet::EdgeContacts;
using bullet::FirstFan;
using bullet::MemberContact;
using bullet::WorldMirror;
using demo::PlugIn;
using demo::Simulation;

WorldMirror::Member member_of(btSoftBody& body) {
  WorldMirror::Member member;
  member.body = &body;
  member.mesh = bullet::read_mesh(body);
  add_faces_of_nodes(member.mesh);
  return member;
}

std::array<Vec3d, 3> corners_of(const Positions3& x, const Triangle& triangle) {
  return {x[triangle.v[0]], x[triangle.v[1]], x[triangle.v[2]]};
}

/// Returns whether triangles intersect or touch, exactly.
bool intersect(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (mesh_tools::intersects(a[i], a[(i + 1) % 3], b) || mesh_tools::intersects(b[i], b[(i + 1) % 3], a)) return true;
  }
  return false;
}

bool has(const Triangle& triangle, std::uint32_t a, std::uint32_t b) {
  const auto has_one = [&](std::uint32_t v) { return triangle.v[0] == v || triangle.v[1] == v || triangle.v[2] == v; };
  return has_one(a) && has_one(b);
}

/// Every vertex against every triangle, and every edge of a triangle against every edge of another, of two meshes or
/// of one with itself.
class AllPairs {
 public:
  AllPairs(btSoftBody& a, btSoftBody& b) : a_(member_of(a)), b_(member_of(b)) {}

  /// How many are tangled, of which brute force knows whether they are.
  std::size_t count() {
    std::size_t count = 0;
    for (const Triangle& triangle : a_.mesh.triangles) {
      for (std::uint32_t f = 0; f < b_.mesh.face_count; ++f) {
        const Triangle& other = b_.mesh.triangles[f];
        count += expect_exact(make(ContactKind::edge_edge, 0, {triangle.v[0], triangle.v[1], other.v[1], other.v[2]}));
      }
      for (std::uint32_t f = 0; f < b_.mesh.face_count; ++f) {
        const Triangle& other = b_.mesh.triangles[f];
        count +=
            expect_exact(make(ContactKind::vertex_triangle, f, {triangle.v[0], other.v[0], other.v[1], other.v[2]}));
      }
    }
    return count;
  }

 private:
  /// The normal leads from one node to another, and often separates the faces there.
  Contact make(ContactKind kind, std::uint32_t feature_b, const std::array<std::uint32_t, 4>& vertices) const {
    Contact contact{};
    contact.kind = kind;
    contact.feature_b = feature_b;
    std::copy(vertices.begin(), vertices.end(), contact.vertices);
    const Vec3d apart = x_of_a_[vertices[0]] - x_of_b_[vertices[3]];
    if (softcd::max_norm(apart) > 0) contact.normal = vec3_cast<float>(softcd::unit_vector(apart));
    return contact;
  }

  bool expect_exact(const Contact& contact) {
    const bool is_same_body = a_.body == b_.body;
    const bool is_vertex = contact.kind == ContactKind::vertex_triangle;
    bool expected = false;
    for (const Triangle& s : a_.mesh.triangles) {
      if (!has(s, contact.vertices[0], contact.vertices[is_vertex ? 0 : 1])) continue;
      for (const Triangle& t : b_.mesh.triangles) {
        const bool is_of_b = has(t, contact.vertices[2], contact.vertices[3]) &&
                             (!is_vertex || has(t, contact.vertices[1], contact.vertices[1]));
        if (!is_of_b || (is_same_body && share_vertex(s, t))) continue;
        expected |= intersect(corners_of(x_of_a_, s), corners_of(x_of_b_, t));
      }
    }
    const WorldMirror::Member& b = is_same_body ? a_ : b_;
    const bool found = is_tangled(MemberContact{contact, a_, b}, bullet::kDeformableEnds, first_);
    EXPECT_EQ(found, expected);
    return found;
  }

  WorldMirror::Member a_, b_;
  Positions3 x_of_a_ = positions_of(*a_.body);
  Positions3 x_of_b_ = positions_of(*b_.body);
  FirstFan first_;  // contacts in a row share it
};

std::unique_ptr<btSoftBody> make_crumpled_sheet(btSoftBodyWorldInfo& world_info, Random& random) {
  SheetOptions options;
  options.nodes_per_side = 5;
  auto sheet = make_sheet(world_info, options);
  for (int n = 0; n < sheet->m_nodes.size(); ++n) {
    const Vec3d shift = random.in_box(0.3);
    sheet->m_nodes[n].m_x += btVector3(btScalar(shift.x), btScalar(shift.y), btScalar(shift.z));
  }
  return sheet;
}

TEST(Tangles, are_those_of_exact_arithmetic) {
  Random random(1);
  btSoftBodyWorldInfo world_info;
  const auto a = make_crumpled_sheet(world_info, random);
  const auto b = make_crumpled_sheet(world_info, random);
  EXPECT_GT(AllPairs(*a, *b).count(), 100U);
  EXPECT_GT(AllPairs(*a, *a).count(), 0U);
}

TEST(Tangles, what_only_touches_is_none) {
  btSoftBodyWorldInfo world_info;
  SheetOptions options;
  options.nodes_per_side = 4;
  auto a = make_sheet(world_info, options);
  options.nodes_per_side = 3;
  auto b = make_sheet(world_info, options);  // in the same plane
  const WorldMirror::Member side_a = member_of(*a);
  const WorldMirror::Member side_b = member_of(*b);
  for (std::uint32_t n = 0; n < side_a.mesh.node_count; ++n) {
    for (std::uint32_t f = 0; f < side_b.mesh.face_count; ++f) {
      Contact contact{};
      contact.feature_b = f;
      contact.vertices[0] = n;
      EXPECT_FALSE(is_tangled(MemberContact{contact, side_a, side_b}, bullet::kDeformableEnds));
    }
  }
}

struct Neighbours {
  int count = 0, tangled = 0;
};

/// Vertices of `a` with faces of `b` that have a corner within a distance of them along every axis.
Neighbours neighbours_of(btSoftBody& a, btSoftBody& b, btScalar distance) {
  const WorldMirror::Member side_a = member_of(a);
  const WorldMirror::Member side_b = member_of(b);
  Neighbours neighbours;
  for (std::uint32_t n = 0; n < side_a.mesh.node_count; ++n) {
    for (std::uint32_t f = 0; f < side_b.mesh.face_count; ++f) {
      const std::uint32_t(&v)[3] = side_b.mesh.triangles[f].v;
      const bool is_near = std::any_of(std::begin(v), std::end(v), [&](std::uint32_t corner) {
        const btVector3 offset = (a.m_nodes[int(n)].m_x - b.m_nodes[int(corner)].m_x).absolute();
        return offset[offset.maxAxis()] <= distance;
      });
      if (!is_near) continue;
      Contact contact{};
      contact.feature_b = f;
      contact.vertices[0] = n;
      std::copy(std::begin(v), std::end(v), contact.vertices + 1);
      ++neighbours.count;
      neighbours.tangled += is_tangled(MemberContact{contact, side_a, side_b}, bullet::kDeformableEnds) ? 1 : 0;
    }
  }
  return neighbours;
}

// A body that passes through faces along their borders intersects the inside of none. It is tangled, and its nodes may
// follow.
TEST(Tangles, are_where_faces_go_through_each_others_borders) {
  constexpr auto kGap = btScalar(0x1p-8);
  btSoftBodyWorldInfo world_info;
  SheetOptions options;
  options.nodes_per_side = 5;
  const auto floor = make_sheet(world_info, options);
  const auto sheet = make_sheet(world_info, options);
  const auto neighbours_when = [&](auto shape) {
    for (int n = 0; n < sheet->m_nodes.size(); ++n) sheet->m_nodes[n].m_x = shape(floor->m_nodes[n].m_x);
    return neighbours_of(*sheet, *floor, kGap);
  };
  const Neighbours upright = neighbours_when([&](btVector3 x) { return btVector3(0, x.x() - kGap, x.z()); });
  EXPECT_GT(upright.count, 20);
  EXPECT_EQ(upright.tangled, upright.count) << "its middle row is below nodes of the floor";
  for (const btScalar height : {btScalar(0), kGap}) {
    const Neighbours valley =
        neighbours_when([&](btVector3 x) { return btVector3(x.x(), btFabs(x.x()) + height, x.z()); });
    EXPECT_GT(valley.count, 20);
    EXPECT_EQ(valley.tangled, 0) << "it stands on the floor, or above it";
  }
}

std::unique_ptr<btSoftBody> make_faces(btSoftBodyWorldInfo& world_info, const std::vector<btVector3>& nodes,
                                       const std::vector<std::array<int, 3>>& faces) {
  auto body = std::make_unique<btSoftBody>(&world_info, static_cast<int>(nodes.size()), nodes.data(), nullptr);
  for (const auto& [a, b, c] : faces) body->appendFace(a, b, c);
  return body;
}

// The upright face passes through the floor's other face. It meets the contact's face at one point alone, inside an
// edge of both, where no corner is on the other's plane.
TEST(Tangles, are_where_edges_of_faces_touch_and_neighbours_intersect) {
  btSoftBodyWorldInfo world_info;
  const auto floor = make_faces(world_info, {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, {{0, 1, 2}, {1, 0, 3}});
  for (const btScalar gap : {btScalar(0), btScalar(0x1p-10)}) {
    const btVector3 shift(0, gap, 0);
    const auto upright = make_faces(
        world_info, {btVector3(0, 0, -1) + shift, btVector3(0, 0, 1) + shift, btVector3(0.25, 1, 0.125) + shift},
        {{0, 1, 2}});
    const WorldMirror::Member side_a = member_of(*floor);
    const WorldMirror::Member side_b = member_of(*upright);
    Contact contact{};
    const std::uint32_t vertices[4] = {3, 0, 1, 2};
    std::copy(std::begin(vertices), std::end(vertices), contact.vertices);
    EXPECT_EQ(is_tangled(MemberContact{contact, side_a, side_b}, bullet::kDeformableEnds), gap == 0);
  }
}

/// Multiples of three, so that the centre has whole coordinates, too.
std::array<Vec3d, 3> lattice_triangle(Random& random) {
  std::array<Vec3d, 3> corners;
  for (Vec3d& corner : corners) {
    const auto next = [&random] { return 3.0 * static_cast<double>(random.below(5)); };
    corner = {next(), next(), next()};
  }
  return corners;
}

/// Returns the triangle without its border. At these sizes no insides meet nearer to the border, so the result is
/// exact.
std::array<Vec3d, 3> without_border(const std::array<Vec3d, 3>& corners) {
  const Vec3d sum = corners[0] + corners[1] + corners[2];
  const Vec3d center = {sum.x / 3, sum.y / 3, sum.z / 3};
  std::array<Vec3d, 3> shrunk;
  for (std::size_t i = 0; i < 3; ++i) shrunk[i] = center + (1 - 0x1p-20) * (corners[i] - center);
  return shrunk;
}

bool are_in_one_plane(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b) {
  const Vec3d normal = cross(a[1] - a[0], a[2] - a[0]);
  return std::all_of(b.begin(), b.end(), [&](Vec3d corner) { return dot(normal, corner - a[0]) == 0; });
}

std::unique_ptr<btSoftBody> make_triangle(btSoftBodyWorldInfo& world_info, const std::array<Vec3d, 3>& corners) {
  btVector3 x[3];
  for (int i = 0; i < 3; ++i) {
    const Vec3d corner = corners[static_cast<std::size_t>(i)];
    x[i] = btVector3(btScalar(corner.x), btScalar(corner.y), btScalar(corner.z));
  }
  const btScalar masses[3] = {1, 1, 1};
  auto body = std::make_unique<btSoftBody>(&world_info, 3, x, masses);
  body->appendFace(0, 1, 2);
  return body;
}

// Triangles of small whole coordinates, whose edges often meet edges and corners.
TEST(Tangles, are_where_insides_of_triangles_meet) {
  Random random(2);
  btSoftBodyWorldInfo world_info;
  int tangled = 0;
  int touching = 0;
  for (int i = 0; i < 10000; ++i) {
    const std::array<Vec3d, 3> a = lattice_triangle(random);
    const std::array<Vec3d, 3> b = lattice_triangle(random);
    if (are_in_one_plane(a, b) || are_in_one_plane(b, a)) continue;
    const auto body_a = make_triangle(world_info, a);
    const auto body_b = make_triangle(world_info, b);
    const WorldMirror::Member side_a = member_of(*body_a);
    const WorldMirror::Member side_b = member_of(*body_b);
    Contact contact{};
    std::iota(contact.vertices + 1, contact.vertices + 4, 0U);
    contact.distance = 100;  // of the vertices that a detection would have found
    const bool expected = intersect(without_border(a), without_border(b));
    EXPECT_EQ(is_tangled(MemberContact{contact, side_a, side_b}, bullet::kDeformableEnds), expected) << i;
    tangled += expected ? 1 : 0;
    touching += !expected && intersect(a, b) ? 1 : 0;
  }
  EXPECT_GT(tangled, 500);
  EXPECT_GT(touching, 500);
}

btScalar kinetic_energy(const std::vector<const btSoftBody*>& bodies) {
  btScalar energy = 0;
  for (const btSoftBody* body : bodies) {
    for (int n = 0; n < body->m_nodes.size(); ++n) energy += body->m_nodes[n].m_v.length2() / body->m_nodes[n].m_im / 2;
  }
  return energy;
}

class TangledCloths : public testing::TestWithParam<std::tuple<PlugIn, EdgeContacts>> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, TangledCloths,
                         testing::Combine(testing::Values(PlugIn::one_line_world, PlugIn::dispatcher),
                                          testing::Values(EdgeContacts::off, EdgeContacts::respond)),
                         [](const auto& parameter) {
                           const bool are_edges_off = std::get<1>(parameter.param) == EdgeContacts::off;
                           return name_of(std::get<0>(parameter.param)) + (are_edges_off ? "" : "_with_edges");
                         });

// Two free patches at rest cross along a line. What pushes them to their margins moves them at first; nothing does
// later on.
TEST_P(TangledCloths, are_not_driven_by_their_contacts) {
  bullet::Settings settings = cpu_settings(Detection::ccd);
  settings.edge_contacts = std::get<1>(GetParam());
  Simulation simulation(std::get<0>(GetParam()), settings);
  simulation.world_info().m_gravity.setZero();
  std::vector<const btSoftBody*> bodies;
  for (const btScalar slope : {btScalar(0), btScalar(0.1)}) {
    demo::ClothShape shape = demo::horizontal_cloth(12, 1, 0);
    shape.position = [flat = shape.position, slope](int column, int row) {
      const btVector3 x = flat(column, row);
      return x + slope * btVector3(btScalar(0.13), x.x() + btScalar(0.2), btScalar(0.17));
    };
    auto cloth = demo::make_cloth(simulation.world_info(), shape, 1);
    cloth->getCollisionShape()->setMargin(btScalar(0.05));
    bodies.push_back(&simulation.add(std::move(cloth)));
  }
  EXPECT_GT(demo::find_intersections(bodies).edge_count, 40U);
  btScalar most_at_first = 0;
  for (int step = 0; step < 10; ++step) {
    simulation.step(kStep);
    most_at_first = btMax(most_at_first, kinetic_energy(bodies));
  }
  EXPECT_LT(most_at_first, 1);
  for (int step = 0; step < 50; ++step) {
    simulation.step(kStep);
    EXPECT_LT(kinetic_energy(bodies), most_at_first) << "step " << step;
  }
  EXPECT_LT(kinetic_energy(bodies), most_at_first / 2);
}

}  // namespace
}  // namespace softcd::test
