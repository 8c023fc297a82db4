#include "scenes/untangling.hpp"

#include "scenes/intersecting_bodies.hpp"

namespace softcd::demo {
namespace {

/// Names of find_intersecting_bodies(), and where they are.
struct Group {
  const char* name;
  btVector3 center;
};
const Group kGroups[] = {
    {"crossed-cloths", btVector3(-2, 1, 0)},
    {"interlocked-cloths", btVector3(0, 1, 0)},
    {"loop", btVector3(2, 1, 0)},
    {"two-balls", btVector3(-2, -1, 0)},
    {"cloth-in-ball", btVector3(0, -1, 0)},
    {"sleeve", btVector3(2, -1, 0)},
};
constexpr btScalar kDrag = btScalar(0.02);  ///< stops bodies that have come apart

SceneOptions with_untangling(SceneOptions options) {
  options.settings.untangle = bullet::Untangle::all;
  return options;
}

/// Moves all nodes. btSoftBody::translate() would measure the links' rest lengths again.
void move(btSoftBody& body, const btVector3& offset) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    body.m_nodes[i].m_x += offset;
    body.m_nodes[i].m_q += offset;
  }
  body.m_pose.m_com += offset;
  body.updateBounds();
}

}  // namespace

Untangling::Untangling(const SceneOptions& options) : Scene(with_untangling(options)) {
  simulation().set_gravity(btVector3(0, 0, 0));
  for (const Group& group : kGroups) {
    const IntersectingBodies& bodies = find_intersecting_bodies(group.name);
    for (auto& body : bodies.make(simulation().world_info(), options.world, options.size)) {
      move(*body, group.center);
      body->m_cfg.kDP = kDrag;
      body->setSelfCollision(true);
      add(std::move(body));
    }
  }
}

std::vector<Surface> Untangling::surfaces() const {
  constexpr Color kFronts[] = {{0.10F, 0.28F, 0.42F}, {0.60F, 0.30F, 0.05F}};
  constexpr Color kBack = {0.45F, 0.42F, 0.35F};
  std::vector<Surface> surfaces;
  for (const btSoftBody* body : simulation().bodies()) {
    surfaces.push_back({body, kFronts[surfaces.size() % std::size(kFronts)], kBack, /*has_edges_drawn=*/true});
  }
  return surfaces;
}

View Untangling::view() const {
  View view{btVector3(btScalar(1.5), btScalar(3.5), 11), btVector3(0, 0, 0)};
  view.floor_height = -3;
  return view;
}

}  // namespace softcd::demo
