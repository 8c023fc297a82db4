#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <functional>
#include <limits>

#include "rival_scene.hpp"
#include "softcd/math/closest_point.hpp"

namespace softcd::benchmarks {
namespace {

using Range = tbb::blocked_range<std::size_t>;

class EmbreeScene final : public RivalScene {
 public:
  EmbreeScene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x)
      : triangles_(triangles), x_(x), device_(rtcNewDevice(nullptr)) {}
  ~EmbreeScene() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  const char* name() const override { return "Embree"; }

  void build() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* const vertices = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), x_.size()));
    std::copy(x_.begin(), x_.end(), vertices);
    auto* const indices = static_cast<Triangle*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle), triangles_.size()));
    std::copy(triangles_.begin(), triangles_.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }

  std::size_t count_hits(const std::vector<Ray>& rays) const override {
    return tbb::parallel_reduce(
        Range(0, rays.size()), std::size_t{0},
        [&](const Range& range, std::size_t hits) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) hits += meets(rays[i]) ? 1 : 0;
          return hits;
        },
        std::plus<>());
  }

  double sum_distances(const std::vector<ProbePoint>& points) const override {
    return tbb::parallel_reduce(
        Range(0, points.size()), 0.0,
        [&](const Range& range, double sum) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) sum += distance(points[i]);
          return sum;
        },
        std::plus<>());
  }

 private:
  struct Nearest {
    const EmbreeScene* scene;
    Vec3f point;
    float squared_distance;
  };

  bool meets(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(ray.origin.x);
    query.ray.org_y = static_cast<float>(ray.origin.y);
    query.ray.org_z = static_cast<float>(ray.origin.z);
    query.ray.dir_x = static_cast<float>(ray.direction.x);
    query.ray.dir_y = static_cast<float>(ray.direction.y);
    query.ray.dir_z = static_cast<float>(ray.direction.z);
    query.ray.tfar = static_cast<float>(ray.t_max);
    query.ray.mask = ~0U;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto& nearest = *static_cast<Nearest*>(arguments->userPtr);
    const Triangle& t = nearest.scene->triangles_[arguments->primID];
    const std::vector<Vec3f>& x = nearest.scene->x_;
    const float squared =
        closest_points_vertex_triangle(nearest.point, x[t.v[0]], x[t.v[1]], x[t.v[2]]).squared_distance;
    if (squared >= nearest.squared_distance) return false;
    nearest.squared_distance = squared;
    arguments->query->radius = std::sqrt(squared);
    return true;
  }

  double distance(const ProbePoint& point) const {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    Nearest nearest{this, vec3_cast<float>(point.point), std::numeric_limits<float>::infinity()};
    RTCPointQuery query{};
    query.x = nearest.point.x;
    query.y = nearest.point.y;
    query.z = nearest.point.z;
    query.radius = std::numeric_limits<float>::infinity();
    rtcPointQuery(scene_, &query, &context, visit, &nearest);
    return static_cast<double>(std::sqrt(nearest.squared_distance));
  }

  const std::vector<Triangle>& triangles_;
  const std::vector<Vec3f>& x_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

}  // namespace

std::unique_ptr<RivalScene> make_embree_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x) {
  return std::make_unique<EmbreeScene>(triangles, x);
}

}  // namespace softcd::benchmarks
