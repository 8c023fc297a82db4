#include "BulletSoftBody/btSoftBody.h"
#include "rival_scene.hpp"
#include "softcd/bullet/world_detection.hpp"

namespace softcd::benchmarks {
namespace {

btVector3 to_bullet(Vec3d x) {
  return {btScalar(x.x), btScalar(x.y), btScalar(x.z)};
}

class BulletScene final : public RivalScene {
 public:
  BulletScene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x) {
    std::vector<btVector3> nodes;
    nodes.reserve(x.size());
    for (const Vec3f& node : x) nodes.push_back(to_bullet(vec3_cast<double>(node)));
    const std::vector<btScalar> masses(x.size(), 1);
    body_ = std::make_unique<btSoftBody>(&info_, static_cast<int>(x.size()), nodes.data(), masses.data());
    for (const Triangle& t : triangles) {
      body_->appendFace(static_cast<int>(t.v[0]), static_cast<int>(t.v[1]), static_cast<int>(t.v[2]));
    }
  }

  const char* name() const override { return "Bullet"; }

  void build() override {
    body_->m_fdbvt.clear();
    body_->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;  // what reads the tree
    body_->m_bUpdateRtCst = false;                             // faces change no more
    bullet::give_face_tree(*body_);
  }

  std::size_t count_hits(const std::vector<Ray>& rays) const override {
    std::size_t hits = 0;
    for (const Ray& ray : rays) {
      btSoftBody::sRayCast result{};
      hits += body_->rayTest(to_bullet(ray.origin), to_bullet(ray.origin + ray.direction), result) ? 1 : 0;
    }
    return hits;
  }

  /// Not compared with softcd's: of 1,000 rays at the generated cloth on a ball it reports 828 as hits, where softcd,
  /// Embree and a test of every triangle in long double report 815.
  bool counts_exactly() const override { return false; }

  double sum_distances(const std::vector<QueryPoint>& /*points*/) const override { return -1; }

 private:
  btSoftBodyWorldInfo info_;
  std::unique_ptr<btSoftBody> body_;
};

}  // namespace

std::unique_ptr<RivalScene> make_bullet_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x) {
  return std::make_unique<BulletScene>(triangles, x);
}

}  // namespace softcd::benchmarks
