#include "crossing_prevention.hpp"

#include <string>

#include "LinearMath/btQuickprof.h"
#include "pair_gate.hpp"
#include "pipeline_options.hpp"

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
    : world_(world), settings_(settings), pipeline_(options(settings)), registry_(pipeline_) {}

PipelineOptions CrossingPrevention::options(const Settings& settings) {
  PipelineOptions options = pipeline_options(settings);
  options.detection = Detection::ccd;
  options.pair_filter = [this](BodyId a, BodyId b) {
    return (*rule_)(*registry_.member(a).body, *registry_.member(b).body);
  };
  return options;
}

void CrossingPrevention::set_settings(const Settings& settings) {
  pipeline_.set_options(options(settings));
  settings_ = settings;
}

void CrossingPrevention::synchronize(Span<btSoftBody* const> bodies) {
  const int flag = world_ == World::classic ? btSoftBody::fCollision::VF_SS : btSoftBody::fCollision::VF_DD;
  for (btSoftBody* body : bodies) {
    if ((body->m_cfg.collisions & flag) == 0 || body->m_nodes.size() == 0) continue;
    BodySettings settings = read_settings(*body, settings_);
    settings.margin = 0;
    // Nobody asks the pair rule about a body and itself.
    if (world_ == World::deformable && !is_deformable_pair(*body, *body)) settings.self_collision = false;
    settings.features.edge_edge = settings_.edge_contacts == EdgeContacts::respond;
    registry_.synchronize(*body, settings);
    if (world_ == World::classic && !body->isActive()) forget_motion(*body);
  }
  registry_.remove_absent();
}

template <class Visit>
void CrossingPrevention::for_each_node(Visit visit) {
  registry_.for_each([&](SoftBodyRegistry::Member& member) {
    for (int i = 0; i < member.body->m_nodes.size(); ++i) visit(*member.body, member.body->m_nodes[i]);
  });
}

void CrossingPrevention::take_velocities(btScalar time_step) {
  velocity_offsets_.clear();
  for_each_node([&](btSoftBody& /*body*/, Node& node) {
    const btVector3 mean = (node.m_x - node.m_q) / time_step;
    velocity_offsets_.push_back(node.m_v - mean);
    node.m_v = mean;
  });
}

void CrossingPrevention::give_velocities() {
  auto offset = velocity_offsets_.begin();
  for_each_node([&](btSoftBody& /*body*/, Node& node) { node.m_v += *offset++; });
}

void CrossingPrevention::move_ends(btScalar time_step) {
  if (world_ == World::classic) {
    for_each_node([&](btSoftBody& /*body*/, Node& node) { node.m_x = node.m_q + time_step * node.m_v; });
    return;
  }
  for_each_node([&](btSoftBody& body, Node& node) {
    // As Bullet will when it moves the nodes.
    const btScalar fastest = body.getWorldInfo()->m_maxDisplacement / time_step;
    for (int axis = 0; axis < 3; ++axis) btClamp(node.m_v[axis], -fastest, fastest);
    node.m_q = node.m_x + time_step * (node.m_v + node.m_splitv);
  });
}

void CrossingPrevention::set_positions() {
  registry_.for_each([&](SoftBodyRegistry::Member& member) {
    const Positions x = positions_x(*member.body);
    const Positions q = positions_q(*member.body);
    if (world_ == World::classic) {
      pipeline_.set_positions(member.id, q, x);
    } else {
      pipeline_.set_positions(member.id, x, q);
    }
  });
}

std::vector<Impact> CrossingPrevention::find_impacts() {
  set_positions();
  std::vector<Impact> impacts;
  registry_.for_each_contact(pipeline_.detect(), [&](const MemberContact& found) {
    if (found.contact.kind == ContactKind::edge_edge || is_with_face(found)) impacts.push_back(impact_of(found));
  });
  return impacts;
}

bool CrossingPrevention::run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step) {
  BT_PROFILE("softcd crossings");
  rule_ = &rule;
  synchronize(bodies);
  if (world_ == World::deformable) move_ends(time_step);
  std::vector<Impact> impacts = find_impacts();
  if (impacts.empty()) return false;

  if (world_ == World::classic) take_velocities(time_step);
  std::vector<Impact> answered;
  ImpactZones zones;
  for (int round = 0; !impacts.empty(); ++round) {
    if (round < kImpulseRounds) {
      // Together with the earlier rounds' impacts: alone, the answer to one can bring back another.
      answered.insert(answered.end(), impacts.begin(), impacts.end());
      apply_inelastic_impulses(answered);
    } else {
      const bool has_joined = zones.join(impacts);
      if (!has_joined || round == kImpulseRounds + kZoneRounds) break;
      zones.move_as_one();
    }
    move_ends(time_step);
    impacts = find_impacts();
  }
  if (world_ == World::classic) give_velocities();
  if (!impacts.empty() && settings_.log) {
    settings_.log(LogLevel::warning, "continuous detection: " + std::to_string(impacts.size()) +
                                         " impacts remain that no change of velocities prevents; nodes without mass "
                                         "or in rigid contact may be moving through each other");
  }
  return true;
}

}  // namespace softcd::bullet
