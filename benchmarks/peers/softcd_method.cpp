#include "methods.hpp"
#include "softcd/math/impact/impact.hpp"

namespace softcd::peers {
namespace {

Vec3d from(const Point& p) {
  return {p.x(), p.y(), p.z()};
}

template <ContactKind kKind>
bool touch(const Point& a_t0, const Point& b_t0, const Point& c_t0, const Point& d_t0, const Point& a_t1,
           const Point& b_t1, const Point& c_t1, const Point& d_t1) {
  const Vec3d t0[4] = {from(a_t0), from(b_t0), from(c_t0), from(d_t0)};
  const Vec3d t1[4] = {from(a_t1), from(b_t1), from(c_t1), from(d_t1)};
  return first_coplanar_impact<kKind>(t0, t1, 0.0).state != ImpactState::separated;
}

}  // namespace

const Method kSoftcd{"softcd", touch<ContactKind::vertex_triangle>, touch<ContactKind::edge_edge>};

}  // namespace softcd::peers
