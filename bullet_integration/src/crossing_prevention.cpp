#include "crossing_prevention.hpp"

#include <string>

#include "LinearMath/btQuickprof.h"
#include "pipeline_options.hpp"
#include "tangles.hpp"

namespace softcd::bullet {
namespace {

/// As often as Bullet's own loop in the deformable world tries.
constexpr int kImpulseRounds = 5;
constexpr int kZoneRounds = 20;

}  // namespace

CrossingPrevention::CrossingPrevention(const WorldKind& kind, const Settings& settings)
    : kind_(kind), settings_(settings), pipeline_(continuous_options(settings), settings.log), registry_(pipeline_) {
  pipeline_.set_pair_filter(
      [this](BodyId a, BodyId b) { return (*rule_)(*registry_.member(a).body, *registry_.member(b).body); });
}

void CrossingPrevention::set_settings(const Settings& settings) {
  pipeline_.set_options(continuous_options(settings));
  pipeline_.set_log(settings.log);
  settings_ = settings;
}

BodySettings CrossingPrevention::body_settings(const btSoftBody& body) const {
  BodySettings settings = read_settings(kind_, body, settings_);
  settings.margin = 0;
  settings.features.edge_edge = settings_.edge_contacts == EdgeContacts::respond;
  return settings;
}

void CrossingPrevention::synchronize(Span<btSoftBody* const> bodies) {
  registry_.compare(bodies);
  for (btSoftBody* body : bodies) {
    if (!has_vertex_face_contacts(kind_, *body)) continue;
    SoftBodyRegistry::Member& member = registry_.synchronize(*body, body_settings(*body));
    if (member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  }
  registry_.remove_absent();
}

void CrossingPrevention::take_up(btSoftBody& body, btScalar time_step) {
  const auto [entry, is_new] = answered_.try_emplace(&body);
  if (!is_new) return;
  NodeStates& before = entry->second;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    before.velocities.push_back(body.m_nodes[i].m_v);
    before.split_velocities.push_back(body.m_nodes[i].m_splitv);
    before.ends.push_back(body.m_nodes[i].*kind_.end);
  }
  kind_.take_up(body, time_step);
}

void CrossingPrevention::take_back() {
  for (const auto& [body, before] : answered_) {
    for (std::size_t i = 0; i < before.ends.size(); ++i) {
      btSoftBody::Node& node = body->m_nodes[static_cast<int>(i)];
      node.m_v = before.velocities[i];
      node.m_splitv = before.split_velocities[i];
      node.*kind_.end = before.ends[i];
    }
  }
}

void CrossingPrevention::set_positions(const btSoftBody& body) {
  pipeline_.set_positions(registry_.id_of(body), positions_of(body, kind_.start), positions_of(body, kind_.end));
}

/// Two bodies that nothing was changed about are where they were when they were found not to meet.
void CrossingPrevention::look_again(btScalar time_step) {
  registry_.for_each([&](SoftBodyRegistry::Member& member) {
    const bool is_answered = answered_.count(member.body) > 0;
    BodySettings settings = body_settings(*member.body);
    settings.kinematic |= !is_answered;
    registry_.set_settings(member, settings);
    if (!is_answered) return;
    kind_.move_end(*member.body, time_step);
    set_positions(*member.body);
  });
}

/// Where no edge passes through another, what is tangled was so from the beginning and could not come apart otherwise.
/// Where edges do, tangles come and go, and vertices still must not pass through faces.
bool CrossingPrevention::is_let_go(const MemberContact& found) const {
  return settings_.edge_contacts == EdgeContacts::respond && is_tangled(found, kind_);
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
    kind_.set_out(*member.body, time_step);
    set_positions(*member.body);
  });
  answered_.clear();
  const std::vector<Impact> impacts = find_impacts();
  if (impacts.empty()) return false;
  try {
    answer(impacts, time_step);
  } catch (...) {
    take_back();
    throw;
  }
  return true;
}

void CrossingPrevention::answer(std::vector<Impact> impacts, btScalar time_step) {
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
  if (!impacts.empty() && settings_.log) {
    settings_.log(LogLevel::warning, "continuous detection: " + std::to_string(impacts.size()) +
                                         " impacts remain that no change of velocities prevents; nodes without mass "
                                         "or in rigid contact may be moving through each other");
  }
  kind_.settle(answered_, answered, zones);
}

}  // namespace softcd::bullet
