#include "native_queries.hpp"

#include "BulletSoftBody/btSoftBodyInternals.h"

namespace softcd::benchmarks {
namespace {

btVector3 to_bullet(Vec3d v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

}  // namespace

struct NativeQueries::Prepared {
  btSoftBody::Node nodes[4];
  btSoftBody::Face face;
};

NativeQueries::NativeQueries(std::span<const test::Query> queries) : prepared_(queries.size()) {
  for (std::size_t q = 0; q < queries.size(); ++q) {
    btSoftBody::Node* const nodes = prepared_[q].nodes;
    btSoftBody::Face& face = prepared_[q].face;
    for (std::size_t i = 0; i < 4; ++i) {
      nodes[i].m_x = to_bullet(queries[q].rows[i]);
      nodes[i].m_q = to_bullet(queries[q].rows[i + 4]);
      nodes[i].m_v = nodes[i].m_q - nodes[i].m_x;  // with a step of 1
      if (i > 0) face.m_n[i - 1] = &nodes[i];
    }
    const auto doubled_area = [&](btVector3 btSoftBody::Node::*field) {
      return (nodes[2].*field - nodes[1].*field).cross(nodes[3].*field - nodes[1].*field);
    };
    face.m_n0 = doubled_area(&btSoftBody::Node::m_x);
    face.m_n1 = doubled_area(&btSoftBody::Node::m_q);
    face.m_vn = doubled_area(&btSoftBody::Node::m_v);
  }
}

NativeQueries::~NativeQueries() = default;

bool NativeQueries::touches(std::size_t query) const {
  const Prepared& prepared = prepared_[query];
  btVector3 weights;
  return bernsteinCCD(&prepared.face, &prepared.nodes[0], /*dt=*/1, SAFE_EPSILON, weights);
}

}  // namespace softcd::benchmarks
