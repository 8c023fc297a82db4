#include "soaked_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "mesh_tools/exact_intersection.hpp"
#include "scenes/penetration.hpp"
#include "scenes/vectors.hpp"
#include "softcd/bullet/world_probe.hpp"

namespace softcd::test {
namespace {

constexpr std::size_t kMostBodies = 8;
constexpr int kMostNodes = 60;  ///< of a sheet that is torn or refined
constexpr btScalar kMargin = btScalar(0.02);

bullet::Settings preventing_crossings() {
  bullet::Settings settings = test_settings(Detection::ccd);
  settings.edge_contacts = bullet::EdgeContacts::respond;
  return settings;
}

btVector3 to_bullet(Vec3d v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

struct Box {
  btVector3 low, high;
};

Box box_of(const btSoftBody& body) {
  Box box{body.m_nodes[0].m_x, body.m_nodes[0].m_x};
  for (int n = 1; n < body.m_nodes.size(); ++n) {
    box.low.setMin(body.m_nodes[n].m_x);
    box.high.setMax(body.m_nodes[n].m_x);
  }
  return box;
}

bool overlap(const Box& a, const Box& b, btScalar distance) {
  bool do_overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    do_overlap &= a.low[axis] <= b.high[axis] + distance && b.low[axis] <= a.high[axis] + distance;
  }
  return do_overlap;
}

bool is_finite(const btSoftBody& body) {
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btVector3& x = body.m_nodes[n].m_x;
    if (!std::isfinite(x.x()) || !std::isfinite(x.y()) || !std::isfinite(x.z())) return false;
  }
  return true;
}

/// Whether a rope passes through a face, or touches it.
bool is_through(const btSoftBody& rope, const btSoftBody& body) {
  for (int l = 0; l < rope.m_links.size(); ++l) {
    const btVector3& p = rope.m_links[l].m_n[0]->m_x;
    const btVector3& q = rope.m_links[l].m_n[1]->m_x;
    for (int f = 0; f < body.m_faces.size(); ++f) {
      const auto corner = [&](int i) { return demo::to_vec3d(body.m_faces[f].m_n[i]->m_x); };
      if (mesh_tools::intersects(demo::to_vec3d(p), demo::to_vec3d(q), {corner(0), corner(1), corner(2)})) return true;
    }
  }
  return false;
}

bool is_rope(const btSoftBody& body) {
  return body.m_faces.size() == 0;
}

/// The plane at which a sheet is to have nodes.
class Plane : public btSoftBody::ImplicitFn {
 public:
  Plane(const btVector3& normal, const btVector3& point) : normal_(normal), point_(point) {}
  btScalar Eval(const btVector3& at) override { return normal_.dot(at - point_); }

 private:
  btVector3 normal_, point_;
};

}  // namespace

SoakedWorld::SoakedWorld(World world, std::uint64_t number)
    : world_(world), random_(number), settings_(preventing_crossings()), simulation_(world, settings_) {
  ground_.addTriangle(btVector3(-30, -1, -30), btVector3(0, -1, 60), btVector3(30, -1, -30));
  simulation_.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&ground_, true), btVector3(0, 0, 0));
  box_ = &simulation_.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.3)),
                                btVector3(btScalar(0.8), btScalar(-0.7), 0));
  pillar_ =
      &simulation_.add(demo::make_ball(simulation_.world_info(), btVector3(0, -btScalar(0.5), 0), btScalar(0.4), 1));
  pillar_->getCollisionShape()->setMargin(kMargin);
}

std::string SoakedWorld::step() {
  if (is_watched() && std::exchange(may_be_tangled_, false)) remove_what_intersects();
  change_something();
  const bool is_judged = is_watched() && !may_be_tangled_;
  const btScalar length = is_deformable(world_) ? kStep / 4 : kStep;
  simulation_.world().stepSimulation(length, /*maxSubSteps=*/0);
  simulation_.finish_step();
  simulation_.world_info().m_sparsesdf.GarbageCollect();
  ++counts_.steps;
  const bullet::WorldDetection& detection = simulation_.detection();
  const Statistics found = detection.contact_report().statistics();
  counts_.contacts += found.vt_contacts;
  counts_.peak_bytes = std::max(counts_.peak_bytes, found.peak_bytes);
  std::string fault = find_fault(is_judged);
  have_nodes_changed_ = false;
  remove_strays();
  return fault;
}

bool SoakedWorld::is_watched() const {
  return settings_.detection == Detection::ccd && settings_.edge_contacts == bullet::EdgeContacts::respond &&
         world_ != World::dispatcher;
}

bool SoakedWorld::may_meet(const btSoftBody& a, const btSoftBody& b) const {
  if (&a != &b) return true;
  const auto is_a = [&](const Member& member) { return member.body == &a; };
  const auto known = std::find_if(members_.begin(), members_.end(), is_a);
  if (known == members_.end() || known->is_torn) return false;  // where it is torn it touches itself
  return settings_.self_collision == bullet::SelfCollision::all ||
         (settings_.self_collision == bullet::SelfCollision::flagged && a.m_useSelfCollision);
}

std::vector<const btSoftBody*> SoakedWorld::bodies() const {
  std::vector<const btSoftBody*> bodies = {pillar_};
  for (const Member& member : members_) bodies.push_back(member.body);
  return bodies;
}

std::string SoakedWorld::find_fault(bool is_judged) {
  for (const btSoftBody* body : bodies()) {
    if (!is_finite(*body)) return "a position is not finite";
  }
  const bullet::WorldDetection& detection = simulation_.detection();
  if (detection.contact_report().failed_steps() + detection.crossing_report().failed_steps() +
          detection.rigid_mesh_report().failed_steps() + detection.convex_shape_report().failed_steps() >
      0) {
    return "a detector has failed";
  }
  if (!is_judged) {
    may_be_tangled_ = true;
    return {};
  }
  ++counts_.watched_steps;
  const bullet::CrossingAnswers answers = detection.crossing_answers();
  counts_.impacts += answers.impacts;
  counts_.held_nodes += answers.held_nodes;
  const std::size_t edges =
      demo::find_intersections(bodies(), [this](const auto& a, const auto& b) { return may_meet(a, b); }).edge_count;
  std::size_t ropes = 0;
  for (const Member& member : members_) {
    if (!is_rope(*member.body)) continue;
    for (const btSoftBody* other : bodies()) ropes += is_through(*member.body, *other);
  }
  if (edges + ropes == 0) return {};
  may_be_tangled_ = true;
  if (answers.unavoidable + answers.excepted > 0) {
    ++counts_.excused;
    return {};
  }
  return std::to_string(edges) + " edges and " + std::to_string(ropes) + " ropes are through faces";
}

// Bullet's deformable world notices new nodes by their number alone. So a step must not add as many nodes as it
// removes.
void SoakedWorld::change_something() {
  if (members_.size() < kMostBodies && !have_nodes_changed_ && random_.chance(0.1)) add_body();
  if (!members_.empty()) {
    const std::size_t some = random_.below(static_cast<std::uint32_t>(members_.size()));
    Member& member = members_[some];
    // Under a Dispatcher Bullet builds the face trees of changed bodies, which never ends for some of these.
    if (member.is_sheet && world_ != World::dispatcher) {
      if (!have_nodes_changed_ && random_.chance(0.05)) tear(member);
      if (!have_nodes_changed_ && random_.chance(0.03)) refine(member);
    }
    if (random_.chance(0.05)) change_body(member);
    if (!have_nodes_changed_ && random_.chance(0.02)) remove(some);
  }
  if (random_.chance(0.02)) change_settings();
  if (random_.chance(0.02)) ask();
  if (random_.chance(0.01)) toggle_box();
}

/// Adds a body in the air, at a place without other bodies.
void SoakedWorld::add_body() {
  Member member{};
  std::unique_ptr<btSoftBody> body = make_body(member);
  const btVector3 place(btScalar(random_.uniform(-0.6, 0.6)), btScalar(random_.uniform(0.3, 1.5)),
                        btScalar(random_.uniform(-0.6, 0.6)));
  body->rotate(btQuaternion(to_bullet(random_.direction()), btScalar(random_.uniform(0, 3))));
  body->translate(place);
  const Box box = box_of(*body);
  for (const btSoftBody* other : bodies()) {
    if (overlap(box, box_of(*other), btScalar(0.1))) return;
  }
  if (is_deformable(world_)) {  // with which Bullet's springs are stable
    for (int n = 0; n < body->m_nodes.size(); ++n) body->setMass(n, btScalar(0.01));
  }
  body->getCollisionShape()->setMargin(kMargin);
  body->setVelocity(to_bullet(random_.in_box(3)));
  if (random_.chance(0.5)) body->setSelfCollision(true);
  member.body = &simulation_.add(std::move(body));
  members_.push_back(member);
  have_nodes_changed_ = true;
  ++counts_.came;
}

std::unique_ptr<btSoftBody> SoakedWorld::make_body(Member& member) {
  btSoftBodyWorldInfo& info = simulation_.world_info();
  using Flags = btSoftBody::fCollision;
  switch (random_.below(3)) {
    case 0: {
      member.is_sheet = true;
      SheetOptions options;
      options.nodes_per_side = 4 + static_cast<int>(random_.below(3));
      options.side = btScalar(random_.uniform(0.5, 1));
      return make_sheet(info, options);
    }
    case 1: {
      std::unique_ptr<btSoftBody> ball(
          btSoftBodyHelpers::CreateEllipsoid(info, btVector3(0, 0, 0), btVector3(1, 1, 1) * btScalar(0.2), 30));
      ball->setTotalMass(1);
      ball->setPose(/*bvolume=*/false, /*bframe=*/true);
      ball->m_cfg.kMT = btScalar(0.1);
      ball->m_cfg.collisions = Flags::SDF_RS | Flags::VF_SS;
      return ball;
    }
    default: {
      std::unique_ptr<btSoftBody> rope(
          btSoftBodyHelpers::CreateRope(info, btVector3(-btScalar(0.5), 0, 0), btVector3(btScalar(0.5), 0, 0), 6, 0));
      rope->setTotalMass(btScalar(0.5));
      rope->m_cfg.piterations = 10;
      rope->m_cfg.collisions = Flags::SDF_RS | Flags::VF_SS;
      return rope;
    }
  }
}

/// Bullet lets bodies that sleep keep contacts with faces that are gone, and solves them when they are woken in a step.
void SoakedWorld::wake_all() {
  for (const Member& member : members_) member.body->activate(/*forceActivation=*/true);
}

void SoakedWorld::remove(std::size_t member) {
  wake_all();
  simulation_.remove(*members_[member].body).reset();
  members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(member));
  have_nodes_changed_ = true;
  ++counts_.went;
}

/// Removes bodies that have fallen past the ground or were thrown away.
void SoakedWorld::remove_strays() {
  for (std::size_t m = members_.size(); m-- > 0;) {
    const Box box = box_of(*members_[m].body);
    const Box room{btVector3(-6, -3, -6), btVector3(6, 9, 6)};
    if (!overlap(box, room, 0)) remove(m);
  }
}

void SoakedWorld::remove_what_intersects() {
  for (std::size_t m = members_.size(); m-- > 0;) {
    const btSoftBody* body = members_[m].body;
    const auto involves = [&](const auto& a, const auto& b) { return (&a == body || &b == body) && may_meet(a, b); };
    bool is_tangled = demo::find_intersections(bodies(), involves).edge_count > 0;
    for (const btSoftBody* other : bodies()) {
      is_tangled |= is_rope(*body) && is_through(*body, *other);
      is_tangled |= is_rope(*other) && is_through(*other, *body);
    }
    if (is_tangled) remove(m);
  }
}

void SoakedWorld::tear(Member& sheet) {
  btSoftBody& body = *sheet.body;
  if (body.m_nodes.size() > kMostNodes) return;
  const btSoftBody::Link& link =
      body.m_links[static_cast<int>(random_.below(static_cast<std::uint32_t>(body.m_links.size())))];
  if (link.m_rl < btScalar(0.05)) return;
  const btScalar mass = 1 / std::max(link.m_n[0]->m_im, btScalar(1));
  const auto node = [&](int i) { return static_cast<int>(link.m_n[i] - &body.m_nodes[0]); };
  wake_all();
  if (!body.cutLink(node(0), node(1), btScalar(0.5))) return;
  for (int added = 1; added <= 2; ++added) body.setMass(body.m_nodes.size() - added, mass);
  sheet.is_torn = true;
  have_nodes_changed_ = true;
  ++counts_.torn_links;
}

void SoakedWorld::refine(Member& sheet) {
  btSoftBody& body = *sheet.body;
  if (body.m_nodes.size() > kMostNodes) return;
  const btVector3 middle = (box_of(body).low + box_of(body).high) / 2;
  Plane plane(to_bullet(random_.direction()), middle);
  wake_all();
  body.refine(&plane, btScalar(0.001), /*cut=*/false);
  have_nodes_changed_ = true;
  ++counts_.refinements;
}

void SoakedWorld::change_body(Member& member) {
  btSoftBody& body = *member.body;
  const int node = static_cast<int>(random_.below(static_cast<std::uint32_t>(body.m_nodes.size())));
  switch (random_.below(5)) {
    case 0:
      body.setSelfCollision(!body.useSelfCollision());
      may_be_tangled_ = true;
      break;
    case 1:
      body.getCollisionShape()->setMargin(kMargin * btScalar(random_.uniform(0.2, 1.5)));
      break;
    case 2:  // it stays there, or falls again
      body.setMass(node, body.m_nodes[node].m_im > 0 ? 0 : btScalar(is_deformable(world_) ? 0.01 : 0.04));
      body.m_nodes[node].m_v.setZero();
      break;
    case 3:
      body.addForce(to_bullet(random_.in_box(is_deformable(world_) ? 0.2 : 20)), node);
      break;
    default: {
      bullet::BodyFilters filters;
      filters.neighbour_rings = 1 + random_.below(3);
      filters.rest_distance = random_.chance(0.5) ? 0.01F : 0.0F;
      simulation_.detection().set_filters(body, filters);
    }
  }
}

void SoakedWorld::change_settings() {
  const auto any = [this](auto... values) {
    const std::array all = {values...};
    return all[random_.below(static_cast<std::uint32_t>(all.size()))];
  };
  settings_ = preventing_crossings();
  if (random_.chance(0.3)) {
    settings_.detection = any(Detection::dcd, Detection::ccd);
    settings_.edge_contacts =
        any(bullet::EdgeContacts::off, bullet::EdgeContacts::report, bullet::EdgeContacts::respond);
  }
  settings_.backend = any(test_settings().backend, Backend::cpu, Backend::automatic);
  settings_.accuracy = any(Accuracy::fast, Accuracy::precise, Accuracy::conservative);
  settings_.broad_phase = any(BroadPhase::exact, BroadPhase::uniform);
  settings_.cell_size_factor = any(0.0F, 1.0F, 3.0F);
  settings_.reuse_pairs = random_.chance(0.7);
  settings_.self_collision =
      any(bullet::SelfCollision::flagged, bullet::SelfCollision::all, bullet::SelfCollision::none);
  settings_.contacts = any(bullet::Contacts::all, bullet::Contacts::closest_feature);
  settings_.contacts_per_node = any(0U, 1U, 4U);
  settings_.rigid_meshes = random_.chance(0.8);
  settings_.convex_shapes = any(bullet::ConvexShapes::nodes, bullet::ConvexShapes::faces_and_edges);
  settings_.filter_deformables = random_.chance(0.5);
  settings_.read_out = any(bullet::ReadOut::off, bullet::ReadOut::contacts, bullet::ReadOut::impulses);
  if (random_.chance(0.5)) settings_.on_contacts = [](const std::vector<bullet::BodyPairContacts>&) {};
  may_be_tangled_ = true;
  const bool is_attached = world_ == World::attached || world_ == World::attached_deformable;
  if (is_attached && random_.chance(0.3)) {
    simulation_.attach_again(settings_);
  } else {
    simulation_.detection().set_settings(settings_);
  }
  ++counts_.settings;
}

void SoakedWorld::toggle_box() {
  has_box_ = !has_box_;
  if (has_box_) {
    simulation_.world().addRigidBody(box_);
  } else {
    simulation_.world().removeRigidBody(box_);
  }
}

void SoakedWorld::ask() {
  const btVector3 from = to_bullet(random_.in_box(2));
  const btVector3 to = to_bullet(random_.in_box(2));
  btCollisionWorld::ClosestRayResultCallback closest(from, to);
  // Other worlds have Bullet's ray test, which builds face trees, and never ends for some torn bodies.
  const bool has_ray_test = world_ == World::one_line || world_ == World::multi_body || world_ == World::deformable;
  if (has_ray_test) simulation_.world().rayTest(from, to, closest);
  bullet::WorldProbe probe(simulation_.world());
  probe.ray_test(from, to, closest);
  simulation_.detection().body_contacts();
  simulation_.detection().contact_report().explain();
}

}  // namespace softcd::test
