#include "soft_soft_detection.hpp"

#include "contact_writer.hpp"

namespace softcd::bullet {
namespace {

// Bullet's rule in CollideVF_SS: a node's margin grows by twice the distance that it moves.
constexpr float kBulletMotionMargin = 2.0F;

PipelineOptions pipeline_options(const Settings& settings, PairFilter pair_filter) {
  PipelineOptions options;
  options.backend = settings.backend;
  options.detection = settings.detection;
  options.accuracy = settings.accuracy;
  options.broad_phase = settings.broad_phase;
  options.lambda = settings.lambda;
  options.motion_margin = settings.detection == Detection::dcd ? kBulletMotionMargin : 0.0F;
  options.pair_filter = std::move(pair_filter);
  options.log = settings.log;
  return options;
}

bool is_same(const BodySettings& a, const BodySettings& b) {
  return a.margin == b.margin && a.self_collision == b.self_collision && a.kinematic == b.kinematic;
}

}  // namespace

SoftSoftDetection::SoftSoftDetection(const Settings& settings)
    : settings_(settings), pipeline_(pipeline_options(settings, pair_filter())) {}

PairFilter SoftSoftDetection::pair_filter() {
  return [this](BodyId a, BodyId b) { return gate_->admits(*member(a).body, *member(b).body); };
}

void SoftSoftDetection::set_settings(const Settings& settings) {
  pipeline_.set_options(pipeline_options(settings, pair_filter()));
  settings_ = settings;
}

void SoftSoftDetection::start(Span<btSoftBody* const> bodies, const PairGate& gate) {
  ++step_;
  for (btSoftBody* body : bodies) {
    const bool takes_part = (body->m_cfg.collisions & btSoftBody::fCollision::VF_SS) != 0 && body->m_nodes.size() > 0;
    if (takes_part) synchronize(*body);
  }
  remove_absent_members();
  gate_ = &gate;
  pipeline_.detect_async();
  gate_ = nullptr;
}

SoftSoftDetection::Member& SoftSoftDetection::add_member(btSoftBody& body, const BodySettings& settings) {
  Member member;
  member.body = &body;
  member.mesh = read_mesh(body);
  member.settings = settings;
  member.topology_changed = true;
  member.id = pipeline_.add_body({member.mesh.triangles, member.mesh.node_count, settings});
  Member& added = members_.emplace(&body, std::move(member)).first->second;
  members_by_id_[added.id.value] = &added;
  return added;
}

void SoftSoftDetection::update_member(Member& member, const BodySettings& settings) {
  member.topology_changed = !is_up_to_date(member.mesh, *member.body);
  if (member.topology_changed) {
    BodyMesh mesh = read_mesh(*member.body);
    pipeline_.update_body(member.id, {mesh.triangles, mesh.node_count, settings});
    member.mesh = std::move(mesh);
  } else if (!is_same(member.settings, settings)) {
    pipeline_.set_settings(member.id, settings);
  }
  member.settings = settings;
}

void SoftSoftDetection::synchronize(btSoftBody& body) {
  const BodySettings settings = read_settings(body, settings_.self_collision);
  const auto known = members_.find(&body);
  if (known != members_.end()) update_member(known->second, settings);
  Member& member = known != members_.end() ? known->second : add_member(body, settings);
  member.last_step = step_;
  // A body that sleeps was not predicted: where it was at the start of its last step means nothing now.
  if (body.isActive()) {
    pipeline_.set_positions(member.id, positions_at_start(body), positions_now(body));
  } else {
    pipeline_.set_positions(member.id, positions_now(body));
  }
}

void SoftSoftDetection::remove_absent_members() {
  for (auto entry = members_.begin(); entry != members_.end();) {
    if (entry->second.last_step == step_) {
      ++entry;
      continue;
    }
    pipeline_.remove_body(entry->second.id);
    members_by_id_.erase(entry->second.id.value);
    entry = members_.erase(entry);
  }
}

void SoftSoftDetection::drop_unread_face_trees() {
  for (auto& [body, member] : members_) member.face_tree.drop_unread_tree(*member.body, member.topology_changed);
}

void SoftSoftDetection::finish() {
  const Member* node_side = nullptr;
  const Member* face_side = nullptr;
  for (const Contact& contact : pipeline_.wait()) {
    if (node_side == nullptr || node_side->id != contact.body_a) node_side = &member(contact.body_a);
    if (face_side == nullptr || face_side->id != contact.body_b) face_side = &member(contact.body_b);
    // Triangles behind the faces stand for single nodes. Bullet neither solves nor clears the contacts of a body
    // that sleeps: they would pile up.
    if (contact.feature_b >= face_side->mesh.face_count || !node_side->body->isActive()) continue;
    write_contact(*node_side->body, *face_side->body, contact, settings_.detection);
  }
}

}  // namespace softcd::bullet
