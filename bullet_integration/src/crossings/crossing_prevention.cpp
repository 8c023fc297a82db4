#include "crossings/crossing_prevention.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "LinearMath/btQuickprof.h"
#include "bodies/bounds.hpp"
#include "contacts/tangles.hpp"

namespace softcd::bullet {
namespace {

/// Gap by which set_apart() separates zones that still meet, relative to the nodes' coordinates, and its growth with
/// each attempt. It is well above the rounding of positions, which could close a narrower gap.
constexpr btScalar kLeastGap = 16 * btScalar(std::numeric_limits<float>::epsilon());
constexpr btScalar kGapGrowth = 4;
constexpr int kMostGaps = 4;

bool prevents_soft_crossings(const Settings& settings) {
  return settings.detection == Detection::ccd;
}

bool answers_edges(const Settings& settings) {
  return !prevents_soft_crossings(settings) || settings.edge_contacts == EdgeContacts::respond;
}

/// Ignores Settings::accuracy and the filters of neighbouring features: no crossing may be missed, also not within a
/// body.
QueryOptions crossing_options(const Settings& settings) {
  QueryOptions options = continuous_options(settings);
  options.accuracy = Accuracy::conservative;
  options.margins = false;
  options.neighbour_filters = false;
  options.features.edge_edge = answers_edges(settings);
  return options;
}

/// Adds the change of momentum and energy of the nodes' own velocities.
void add_gain(const btSoftBody& body, const NodeStates& before, CrossingAnswers& answers) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btSoftBody::Node& node = body.m_nodes[i];
    if (!(node.m_im > 0)) continue;
    const btVector3& old_velocity = before.velocities[static_cast<std::size_t>(i)];
    double gain = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double change = (double(node.m_v[axis]) - double(old_velocity[axis])) / double(node.m_im);
      answers.momentum[axis] += change;
      gain += change * (double(node.m_v[axis]) + double(old_velocity[axis])) / 2;
    }
    answers.energy += gain;
  }
}

}  // namespace

CrossingPrevention::CrossingPrevention(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings)
    : kind_(kind),
      mirror_(mirror),
      settings_(settings),
      query_(mirror.scene(), crossing_options(settings)),
      obstacles_(mirror) {
  held_.anchor();
}

void CrossingPrevention::follow_settings() {
  query_.set_options(crossing_options(settings_));
  answers_ = {};
}

void CrossingPrevention::keep_starts(Span<btSoftBody* const> bodies) {
  starts_.clear();
  for (const btSoftBody* body : bodies) {
    if (body->m_cfg.diterations <= 0 || !has_vertex_face_contacts(kind_.ends, *body)) continue;
    starts_[body] = values_of(*body, kind_.ends.start);
  }
}

void CrossingPrevention::restore_start(btSoftBody& body) const {
  const auto kept = starts_.find(&body);
  if (kept == starts_.end() || kept->second.size() != static_cast<std::size_t>(body.m_nodes.size())) return;
  set_values(body, kind_.ends.start, kept->second);
}

void CrossingPrevention::round_ends(btSoftBody& body) const {
  if (moved_ != nullptr) moved_->round_ends(body);
}

void CrossingPrevention::take_up(btSoftBody& body, btScalar time_step) {
  NodeStates* const before = answered_.add(body);
  if (before == nullptr) return;
  before->velocities = values_of(body, &btSoftBody::Node::m_v);
  before->split_velocities = values_of(body, &btSoftBody::Node::m_splitv);
  before->ends = values_of(body, kind_.ends.end);
  kind_.take_up(body, time_step);
  constrained_.add(body);
}

void CrossingPrevention::take_up(Impact& impact, btScalar time_step) {
  for (int side = 0; side < 2; ++side) {
    btSoftBody& body = *impact.bodies[side];
    if (!obstacles_.has(body)) {
      take_up(body, time_step);
    } else if (btRigidBody* const rigid = obstacles_.free_body_of(body)) {
      impact.rigid = rigid;
      impact.rigid_sign = btScalar(side == 0 ? 1 : -1);
    }
  }
  for (int i = 0; i < 4; ++i) {
    const btSoftBody& body = *impact.bodies[i < vertices_of_a(impact.contact) ? 0 : 1];
    const bool stays = do_inactive_bodies_stay_ && !body.isActive();
    impact.constraints[i] = stays ? &held_ : constrained_.find(*impact.nodes[i]);
  }
  if (settings_.read_out == ReadOut::impulses) note_meeting(impact);
}

void CrossingPrevention::note_meeting(const Impact& impact) {
  for (int i = 0; i < 4; ++i) {
    const btSoftBody& other = *impact.bodies[i < vertices_of_a(impact.contact) ? 1 : 0];
    if (impact.nodes[i]->m_im > 0) impulses_.add(*impact.nodes[i], obstacles_.object_of(other));
  }
}

/// Holds the rigid bodies of the impacts where the step began. Returns false if all of them are held already.
bool CrossingPrevention::hold_rigid_bodies(const std::vector<Impact>& impacts) {
  bool has_held = false;
  for (const Impact& impact : impacts) has_held |= impact.rigid != nullptr && obstacles_.hold(*impact.rigid);
  return has_held;
}

void CrossingPrevention::take_back() const {
  for (const auto& [body, before] : answered_) {
    set_values(*body, &btSoftBody::Node::m_v, before.velocities);
    set_values(*body, &btSoftBody::Node::m_splitv, before.split_velocities);
    set_values(*body, kind_.ends.end, before.ends);
  }
}

void CrossingPrevention::update_positions(const HeldNodes& held, btScalar time_step) {
  for (const auto& [body, before] : answered_) {
    kind_.move_end(*body, time_step);
    round_ends(*body);
  }
  held.put_back();
  std::vector<btSoftBody*> bodies;
  for (const auto& [body, before] : answered_) {
    mirror_.update_way(mirror_.member(*body));
    bodies.push_back(body);
  }
  obstacles_.follow({bodies.data(), bodies.size()});
  require_neighbours({bodies.data(), bodies.size()}, time_step);
}

/// Returns whether the features are released as tangled. If edges get responses, no edge passes through another. So
/// tangled features were tangled from the beginning, and must be able to separate. Without these responses tangles come
/// and go, and vertices must still not pass through faces.
bool CrossingPrevention::is_released(const MemberContact& found, FirstFan& first) const {
  return answers_edges(settings_) && is_tangled(found, kind_.ends, first);
}

/// Returns whether a node of the contact moves out of the other side's object.
bool CrossingPrevention::moves_out(const MemberContact& found) const {
  return released_ != nullptr &&
         released_->has_one_of(
             found, [this](const btSoftBody& body) -> const auto& { return obstacles_.object_of(body); });
}

/// Links of ropes get responses to other soft bodies only with EdgeContacts::respond, to rigid meshes always.
bool CrossingPrevention::is_of_unanswered_link(const MemberContact& found) const {
  return found.contact.kind == ContactKind::edge_edge && settings_.edge_contacts != EdgeContacts::respond &&
         !(found.a.mesh.segments.empty() && found.b.mesh.segments.empty()) &&
         !(obstacles_.has(*found.a.body) || obstacles_.has(*found.b.body));
}

/// Returns whether the features touch at the start and stay untangled: they may separate, slide or stay. Features that
/// touch only up to rounding stay on their sides.
bool CrossingPrevention::may_stay(const MemberContact& found) const {
  return found.contact.time_of_impact <= 0 && !change_sides(found, kind_.ends) &&
         !may_be_tangled_at_the_end(found, kind_.ends);
}

std::vector<Impact> CrossingPrevention::find_impacts(Pairs pairs) {
  std::vector<Impact> impacts;
  std::uint64_t excepted = 0;
  FirstFan first;
  mirror_.for_each_contact(query_.detect(pairs), [&](const MemberContact& found) {
    if (found.contact.kind != ContactKind::edge_edge && !is_with_face(found)) return;
    if (is_of_unanswered_link(found)) return;
    if (moves_out(found)) return;
    if (is_released(found, first)) {
      ++excepted;
      tangled_.add(found.contact, TangleReason::start);
    } else if (!may_stay(found)) {
      impacts.push_back(impact_of(found));
    }
  });
  answers_.excepted = std::max(answers_.excepted, excepted);
  return impacts;
}

/// Puts the body into the mirror with its path before any response.
void CrossingPrevention::require(btSoftBody& body, btScalar time_step) {
  WorldMirror::Member& member = mirror_.require(body, /*needs_way=*/true);
  restore_start(body);
  kind_.set_out(body, time_step);
  round_ends(body);
  mirror_.update_way(member);
  required_.insert(&body);
}

/// Puts the bodies and the obstacles near them into the mirror. Returns false if there are no bodies.
bool CrossingPrevention::require(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step) {
  required_.clear();
  std::vector<btSoftBody*> looked_after;
  for (btSoftBody* body : bodies) {
    if (prevents_soft_crossings(settings_) && !has_vertex_face_contacts(kind_.ends, *body)) continue;
    require(*body, time_step);
    looked_after.push_back(body);
  }
  obstacles_.begin_step({looked_after.data(), looked_after.size()}, surroundings, time_step);
  return !looked_after.empty();
}

/// Returns whether two soft bodies must not cross. With discrete detection that holds only if a response has moved one
/// of them: the pass itself must push no body through another.
bool CrossingPrevention::keeps_apart(btSoftBody& a, btSoftBody& b, const PairRule& rule) const {
  if (prevents_soft_crossings(settings_)) return rule(a, b);
  return (answered_.has(a) || answered_.has(b)) && required_.count(&a) != 0 && required_.count(&b) != 0 &&
         has_vertex_face_contacts(kind_.ends, a) && has_vertex_face_contacts(kind_.ends, b) && rule(a, b);
}

/// Returns whether a body must not cross itself. With discrete detection that holds only if a response has moved it.
bool CrossingPrevention::keeps_from_itself(BodyId id) const {
  if (prevents_soft_crossings(settings_)) return true;
  const WorldMirror::Member* const member = mirror_.find(id);
  return member != nullptr && answered_.has(*member->body) && has_vertex_face_contacts(kind_.ends, *member->body);
}

/// Requires the soft bodies that moved bodies may reach.
void CrossingPrevention::require_neighbours(Span<btSoftBody* const> moved, btScalar time_step) {
  if (prevents_soft_crossings(settings_)) return;
  const auto path_of = [](const btSoftBody& body) {
    return bounds_of(body, {&btSoftBody::Node::m_x, &btSoftBody::Node::m_q});
  };
  std::vector<Bounds> paths;
  for (const btSoftBody* body : moved) paths.push_back(path_of(*body));
  for (btSoftBody* body : neighbours_) {
    if (required_.count(body) != 0 || !has_vertex_face_contacts(kind_.ends, *body)) continue;
    const Bounds path = path_of(*body);
    if (std::any_of(paths.begin(), paths.end(), [&](const Bounds& other) { return other.overlaps(path); })) {
      require(*body, time_step);
    }
  }
}

bool CrossingPrevention::run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step,
                             const Surroundings& surroundings, const TangledNodes* released,
                             const MasslessNodePaths* moved) {
  BT_PROFILE("softcd crossings");
  released_ = released;
  moved_ = moved;
  neighbours_ = surroundings.soft_bodies;
  const bool has_any = require(bodies, surroundings, time_step);
  const PairRule rule_of_all = [&](btSoftBody& a, btSoftBody& b) {
    if (obstacles_.has(a) || obstacles_.has(b)) return obstacles_.collide(a, b);
    return keeps_apart(a, b, rule);
  };
  const PairFilter filter = pair_filter(mirror_, rule_of_all);
  query_.set_pair_filter([&](BodyId a, BodyId b) { return a == b ? keeps_from_itself(a) : filter(a, b); });
  answered_.clear();
  ends_.clear();
  constrained_.clear();
  tangled_.begin_step();
  answers_ = {};
  impulses_.clear();
  std::vector<Impact> impacts;
  if (has_any || !had_no_bodies(query_)) impacts = find_impacts(Pairs::all);
  try {
    if (!impacts.empty()) answer(impacts, time_step);
    if (settings_.read_out == ReadOut::impulses) impulses_.measure(kind_, answered_, time_step);
    name_new_pairs(neighbours_.empty() ? bodies : neighbours_);
  } catch (...) {
    obstacles_.release_held();
    take_back();
    throw;
  }
  obstacles_.end_step();
  return !impacts.empty();
}

void CrossingPrevention::place_ends() {
  for (const auto& [body, ends] : std::exchange(ends_, {})) {
    set_values(*body, &btSoftBody::Node::m_x, ends);
    set_values(*body, &btSoftBody::Node::m_q, ends);
  }
}

/// The responses to the impacts of a step, weakest first.
struct CrossingPrevention::Responses {
  std::vector<Impact> answered;
  ImpactZones zones;
  HeldNodes held;
  int gaps = 0;
};

/// Changes the nodes' ends until nothing meets. Returns the impacts that no response prevents.
std::vector<Impact> CrossingPrevention::respond(std::vector<Impact> impacts, Responses& responses, btScalar time_step) {
  auto& [answered, zones, held, gaps] = responses;
  for (std::uint64_t round = 0; !impacts.empty() && round < kind_.rounds.last; ++round) {
    for (Impact& impact : impacts) take_up(impact, time_step);
    if (round < kind_.rounds.impulses) {
      // Also applies the earlier rounds' impacts: the response to one impact alone can bring back another.
      answered.insert(answered.end(), impacts.begin(), impacts.end());
      apply_inelastic_impulses(answered);
      if (kind_.limit_stretch(answered_, time_step)) apply_inelastic_impulses(answered);
    } else if (round < kind_.rounds.zones && held.empty() && zones.join(impacts)) {
      zones.move_as_one();
    } else if (gaps < kMostGaps && held.empty() &&
               set_apart(impacts, kind_.passing_velocity, kLeastGap * btPow(kGapGrowth, btScalar(gaps)), time_step)) {
      ++gaps;
    } else if ((round < kind_.rounds.nodes ? !held.add(impacts) : !held.add_bodies(impacts)) &&
               !hold_rigid_bodies(impacts)) {
      break;
    }
    ++answers_.rounds;
    update_positions(held, time_step);
    impacts = find_impacts(Pairs::changed);
  }
  return impacts;
}

void CrossingPrevention::answer(std::vector<Impact> impacts, btScalar time_step) {
  const auto no_responses = [&] { return Responses{{}, {kind_.ends.start, time_step}, {kind_, constrained_}}; };
  answers_.impacts = impacts.size();
  std::optional<Responses> responses(no_responses());
  do_inactive_bodies_stay_ = true;
  impacts = respond(std::move(impacts), *responses, time_step);
  if (is_left_to_inactive_bodies(impacts)) {
    do_inactive_bodies_stay_ = false;
    responses.emplace(no_responses());
    impacts = respond(begin_again(), *responses, time_step);
  }
  answers_.held_nodes = responses->held.size();
  count_unavoidable(impacts);
  if (kind_.finish(answered_, responses->answered, responses->zones, time_step)) {
    for (const auto& [body, before] : answered_) ends_.emplace_back(body, values_of(*body, kind_.ends.end));
  }
  obstacles_.stop_held();
  for (const auto& [body, before] : answered_) add_gain(*body, before, answers_);
}

/// Returns whether the impacts cannot be prevented while inactive bodies stay.
bool CrossingPrevention::is_left_to_inactive_bodies(const std::vector<Impact>& impacts) const {
  return std::any_of(impacts.begin(), impacts.end(), [this](const Impact& impact) { return moves(impact); }) &&
         std::any_of(answered_.begin(), answered_.end(), [](const auto& each) { return !each.first->isActive(); });
}

/// Takes the responses of soft bodies back, and returns the impacts of then. Held rigid meshes stay held.
std::vector<Impact> CrossingPrevention::begin_again() {
  take_back();
  for (const auto& [body, before] : answered_) mirror_.update_way(mirror_.member(*body));
  answered_.clear();
  constrained_.clear();
  impulses_.clear();
  return find_impacts(Pairs::all);
}

/// Returns whether a node of the impact moves in this step.
bool CrossingPrevention::moves(const Impact& impact) const {
  return std::any_of(std::begin(impact.nodes), std::end(impact.nodes),
                     [this](const btSoftBody::Node* node) { return node->*kind_.ends.start != node->*kind_.ends.end; });
}

/// Counts the impacts that remain after all movable nodes are held.
void CrossingPrevention::count_unavoidable(const std::vector<Impact>& impacts) {
  for (const Impact& impact : impacts) {
    if (!moves(impact)) continue;
    ++answers_.unavoidable;
    tangled_.add(impact.contact, TangleReason::unavoidable);
  }
}

/// Warns of the pairs of these bodies that are new in this step.
void CrossingPrevention::name_new_pairs(Span<btSoftBody* const> bodies) const {
  if (!settings_.log) return;
  const auto name = [&](TangleReason reason, auto text_of) {
    const std::string pairs = tangled_.describe_new(reason, mirror_, bodies);
    if (!pairs.empty()) settings_.log(LogLevel::warning, "prevention of crossings: " + text_of(pairs));
  };
  name(TangleReason::unavoidable, [this](const std::string& pairs) {
    return "in " + std::to_string(answers_.unavoidable) + " impacts of " + pairs +
           " a body is crossed by features that the app moves (nodes without mass, nodes on anchors, or rigid meshes) "
           "and has no place to go; move them less in a step, or leave more space in front of them (reported once "
           "until these bodies have been apart for 64 steps)";
  });
  name(TangleReason::start, [this](const std::string& pairs) {
    return "bodies already intersect at the start of the step, and may move through each other there until they "
           "separate, in " +
           std::to_string(answers_.excepted) + " pairs of features in this step: " + pairs +
           " (reported once until these bodies have been apart for 64 steps; their other crossings are still "
           "prevented)";
  });
}

}  // namespace softcd::bullet
