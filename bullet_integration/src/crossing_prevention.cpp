#include "crossing_prevention.hpp"

#include <string>

#include "LinearMath/btQuickprof.h"
#include "pair_gate.hpp"
#include "pipeline_options.hpp"
#include "tangles.hpp"

namespace softcd::bullet {
namespace {

/// As often as Bullet's own loop in the deformable world tries.
constexpr int kImpulseRounds = 5;
constexpr int kZoneRounds = 20;

/// A body that sleeps was not predicted: where it was at the start of its last step means nothing now.
void forget_motion(btSoftBody& body) {
  for (int i = 0; i < body.m_nodes.size(); ++i) body.m_nodes[i].m_q = body.m_nodes[i].m_x;
}

}  // namespace

CrossingPrevention::CrossingPrevention(World world, const Settings& settings)
    : world_(world), settings_(settings), pipeline_(continuous_options(settings), settings.log), registry_(pipeline_) {
  pipeline_.set_pair_filter(
      [this](BodyId a, BodyId b) { return (*rule_)(*registry_.member(a).body, *registry_.member(b).body); });
}

void CrossingPrevention::set_settings(const Settings& settings) {
  pipeline_.set_options(continuous_options(settings));
  pipeline_.set_log(settings.log);
  settings_ = settings;
}

BodySettings CrossingPrevention::body_settings(const btSoftBody& body) const {
  BodySettings settings = read_settings(body, settings_);
  settings.margin = 0;
  // Nobody asks the pair rule about a body and itself.
  if (world_ == World::deformable && !is_deformable_pair(body, body)) settings.self_collision = false;
  settings.features.edge_edge = settings_.edge_contacts == EdgeContacts::respond;
  return settings;
}

void CrossingPrevention::synchronize(Span<btSoftBody* const> bodies) {
  const int flag = world_ == World::classic ? btSoftBody::fCollision::VF_SS : btSoftBody::fCollision::VF_DD;
  registry_.compare(bodies);
  for (btSoftBody* body : bodies) {
    if ((body->m_cfg.collisions & flag) == 0 || body->m_nodes.size() == 0) continue;
    SoftBodyRegistry::Member& member = registry_.synchronize(*body, body_settings(*body));
    if (member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
    if (world_ == World::classic && !body->isActive()) forget_motion(*body);
  }
  registry_.remove_absent();
}

/// In the classic world the nodes' velocities become the mean ones of the step.
void CrossingPrevention::take_up(btSoftBody& body, btScalar time_step) {
  const auto [entry, is_new] = answered_.try_emplace(&body);
  if (!is_new || world_ == World::deformable) return;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    entry->second.push_back(node.m_v);
    node.m_v = (node.m_x - node.m_q) / time_step;
  }
}

/// The nodes' own velocities need not be the mean ones: Bullet moves a body's nodes, for the contacts of the bodies
/// after it, when it has its velocities already. Changed by what the mean ones were changed by, they could gain energy.
void CrossingPrevention::answer_own_velocities(const std::vector<Impact>& impacts, ImpactZones& zones) {
  for (const auto& [body, velocities] : answered_) {
    for (std::size_t i = 0; i < velocities.size(); ++i) body->m_nodes[static_cast<int>(i)].m_v = velocities[i];
  }
  apply_inelastic_impulses(impacts);
  zones.move_as_one();
}

void CrossingPrevention::move_end(btSoftBody& body, btScalar time_step) const {
  const btScalar fastest = body.getWorldInfo()->m_maxDisplacement / time_step;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    if (world_ == World::classic) {
      node.m_x = node.m_q + time_step * node.m_v;
      continue;
    }
    // As Bullet will when it moves the nodes.
    for (int axis = 0; axis < 3; ++axis) btClamp(node.m_v[axis], -fastest, fastest);
    node.m_q = node.m_x + time_step * (node.m_v + node.m_splitv);
  }
}

void CrossingPrevention::set_positions(const btSoftBody& body) {
  const Positions x = positions_x(body);
  const Positions q = positions_q(body);
  const bool is_q_first = world_ == World::classic;
  pipeline_.set_positions(registry_.id_of(body), is_q_first ? q : x, is_q_first ? x : q);
}

/// Two bodies that nothing was changed about are where they were when they were found not to meet.
void CrossingPrevention::look_again(btScalar time_step) {
  registry_.for_each([&](SoftBodyRegistry::Member& member) {
    const bool is_answered = answered_.count(member.body) > 0;
    BodySettings settings = body_settings(*member.body);
    settings.kinematic |= !is_answered;
    registry_.set_settings(member, settings);
    if (!is_answered) return;
    move_end(*member.body, time_step);
    set_positions(*member.body);
  });
}

/// Where no edge passes through another, what is tangled was so from the beginning and could not come apart otherwise.
/// Where edges do, tangles come and go, and vertices still must not pass through faces.
bool CrossingPrevention::is_let_go(const MemberContact& found) const {
  if (settings_.edge_contacts != EdgeContacts::respond) return false;
  return is_tangled(found, world_ == World::classic ? StepStart::in_q : StepStart::in_x);
}

std::vector<Impact> CrossingPrevention::find_impacts() {
  std::vector<Impact> impacts;
  registry_.for_each_contact(pipeline_.detect(), [&](const MemberContact& found) {
    const bool has_faces = found.contact.kind == ContactKind::edge_edge || is_with_face(found);
    if (has_faces && !is_let_go(found)) impacts.push_back(impact_of(found));
  });
  return impacts;
}

bool CrossingPrevention::run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step) {
  BT_PROFILE("softcd crossings");
  rule_ = &rule;
  synchronize(bodies);
  registry_.for_each([&](SoftBodyRegistry::Member& member) {
    if (world_ == World::deformable) move_end(*member.body, time_step);
    set_positions(*member.body);
  });
  std::vector<Impact> impacts = find_impacts();
  if (impacts.empty()) return false;

  answered_.clear();
  std::vector<Impact> answered;
  ImpactZones zones;
  for (int round = 0; !impacts.empty(); ++round) {
    for (const Impact& impact : impacts) {
      for (btSoftBody* body : impact.bodies) take_up(*body, time_step);
    }
    if (round < kImpulseRounds) {
      // Together with the earlier rounds' impacts: alone, the answer to one can bring back another.
      answered.insert(answered.end(), impacts.begin(), impacts.end());
      apply_inelastic_impulses(answered);
    } else {
      const bool has_joined = zones.join(impacts);
      if (!has_joined || round == kImpulseRounds + kZoneRounds) break;
      zones.move_as_one();
    }
    look_again(time_step);
    impacts = find_impacts();
  }
  if (world_ == World::classic) answer_own_velocities(answered, zones);
  if (!impacts.empty() && settings_.log) {
    settings_.log(LogLevel::warning, "continuous detection: " + std::to_string(impacts.size()) +
                                         " impacts remain that no change of velocities prevents; nodes without mass "
                                         "or in rigid contact may be moving through each other");
  }
  return true;
}

}  // namespace softcd::bullet
