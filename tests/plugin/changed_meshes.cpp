#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "fans.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "scene_parts.hpp"
#include "softcd/mesh/features.hpp"

// Bodies with some changed triangles have the contacts of a scene that is made anew.
namespace softcd::test {
namespace {

/// A contact without the indices of edges: within a body, the edge of the lower vertices comes first.
using Touching = std::tuple<ContactKind, std::uint32_t, std::uint32_t, std::array<std::uint32_t, 4>, std::uint32_t>;

Touching touching(const Contact& contact, const std::map<std::uint32_t, std::uint32_t>& places) {
  const std::uint32_t a = places.at(contact.body_a.value);
  const std::uint32_t b = places.at(contact.body_b.value);
  std::array<std::uint32_t, 4> v{};
  std::copy(contact.vertices, contact.vertices + 4, v.begin());
  if (contact.kind == ContactKind::vertex_triangle) return {contact.kind, a, b, v, contact.feature_b};
  if (a == b && std::pair(v[2], v[3]) < std::pair(v[0], v[1])) v = {v[2], v[3], v[0], v[1]};
  return {contact.kind, a, b, v, 0U};
}

std::vector<Touching> all_touching(Span<const Contact> contacts, const std::map<std::uint32_t, std::uint32_t>& places) {
  std::vector<Touching> all;
  for (const Contact& contact : contacts) all.push_back(touching(contact, places));
  std::sort(all.begin(), all.end());
  return all;
}

std::uint32_t vertex_count(const SceneBody& body) {
  return static_cast<std::uint32_t>(body.x_t1.size());
}

/// Changes a mesh as an app does, and lists the changed triangles.
class Surgeon {
 public:
  explicit Surgeon(Random& random) : random_(random) {}

  std::vector<std::uint32_t> operate(SceneBody& body, int operations) {
    changed_.clear();
    for (; operations > 0; --operations) operate(body);
    // Changed triangles may have been removed.
    std::erase_if(changed_, [&](std::uint32_t t) { return t >= body.triangles.size(); });
    return changed_;
  }

 private:
  void operate(SceneBody& body) {
    if (body.triangles.empty()) {
      append(body, {{0, 0, 0}});
      return;
    }
    const std::uint32_t t = random_.below(static_cast<std::uint32_t>(body.triangles.size()));
    switch (random_.below(5)) {
      case 0:
        return split(body, t);
      case 1:
        return tear(body, t);
      case 2:
        return remove(body, t);
      case 3:
        return replace(body, t, random_triangle(body));
      default:
        return remove_last_vertex(body);
    }
  }
  void split(SceneBody& body, std::uint32_t t) {
    const auto [a, b, c] = body.triangles[t].v;
    const std::uint32_t middle = vertex_count(body);
    for (Positions3* const x : {&body.x_t0, &body.x_t1}) {
      x->push_back((1.0 / 3.0) * ((*x)[a] + (*x)[b] + (*x)[c]));
      snap_to_grid(*x, 17);
    }
    replace(body, t, {{a, b, middle}});
    append(body, {{b, c, middle}});
    append(body, {{c, a, middle}});
  }
  void tear(SceneBody& body, std::uint32_t t) {
    Triangle torn = body.triangles[t];
    std::uint32_t& corner = torn.v[random_.below(3)];
    body.x_t0.push_back(body.x_t0[corner]);
    body.x_t1.push_back(body.x_t1[corner]);
    corner = vertex_count(body) - 1;
    replace(body, t, torn);
  }
  void remove(SceneBody& body, std::uint32_t t) {
    replace(body, t, body.triangles.back());
    body.triangles.pop_back();
  }
  void remove_last_vertex(SceneBody& body) {
    if (vertex_count(body) < 3) return;
    body.x_t0.pop_back();
    body.x_t1.pop_back();
    for (std::uint32_t t = 0; t < body.triangles.size(); ++t) {
      Triangle triangle = body.triangles[t];
      if (!has_vertex(triangle, vertex_count(body))) continue;
      std::replace(triangle.v, triangle.v + 3, vertex_count(body), vertex_count(body) - 1);
      replace(body, t, triangle);
    }
  }
  Triangle random_triangle(const SceneBody& body) {
    Triangle triangle{};
    const std::uint32_t nearby = random_.below(vertex_count(body));
    for (std::uint32_t& v : triangle.v) v = (nearby + random_.below(4)) % vertex_count(body);
    return triangle;
  }
  void replace(SceneBody& body, std::uint32_t t, const Triangle& triangle) {
    body.triangles[t] = triangle;
    changed_.push_back(t);
  }
  /// Appends a triangle. After a removal its place may be one that the body had before.
  void append(SceneBody& body, const Triangle& triangle) {
    changed_.push_back(static_cast<std::uint32_t>(body.triangles.size()));
    body.triangles.push_back(triangle);
  }

  Random& random_;
  std::vector<std::uint32_t> changed_;
};

/// A scene whose meshes are changed, and the expected scene.
class Hospital {
 public:
  Hospital(std::uint64_t seed, Scene bodies) : random_(seed), bodies_(std::move(bodies)), scene_(scene_options()) {
    for (const Detection detection : {Detection::dcd, Detection::ccd})
      queries_.emplace_back(scene_, looking_for(detection));
    for (const SceneBody& body : bodies_) add(body);
  }

  void operate() {
    const std::uint32_t b = random_.below(static_cast<std::uint32_t>(bodies_.size()));
    SceneBody& body = bodies_[b];
    if (random_.chance(0.05)) {
      scene_.update_body(ids_[b], desc_of(body));
    } else if (random_.chance(0.05)) {
      replace_last();
    } else if (random_.chance(0.1)) {
      body.settings.self_collision = !body.settings.self_collision;
      scene_.set_settings(ids_[b], body.settings);
    } else {
      const std::vector<std::uint32_t> changed = surgeon_.operate(body, 1 + static_cast<int>(random_.below(4)));
      scene_.update_body(ids_[b], desc_of(body), changed);
    }
    move(body);
  }

  /// Returns the number of contacts.
  std::size_t expect_contacts_as_anew() {
    for (std::size_t b = 0; b < bodies_.size(); ++b) scene_.set_positions(ids_[b], bodies_[b].x_t0, bodies_[b].x_t1);
    std::map<std::uint32_t, std::uint32_t> places;
    std::map<std::uint32_t, std::uint32_t> same;
    for (std::uint32_t b = 0; b < bodies_.size(); ++b) places[ids_[b].value] = same[b] = b;
    std::size_t count = 0;
    for (Query& query : queries_) {
      const Outcome expected = outcome_of(bodies_, test_options(query.options().detection));
      const Span<const Contact> found = query.detect();
      EXPECT_EQ(all_touching(found, places), all_touching(expected.contacts, same));
      EXPECT_EQ(query.statistics().triangles, expected.statistics.triangles);
      EXPECT_EQ(query.statistics().vertices, expected.statistics.vertices);
      EXPECT_EQ(query.statistics().edges, expected.statistics.edges);
      EXPECT_EQ(query.statistics().left_out_triangles, expected.statistics.left_out_triangles);
      count += found.size();
    }
    return count;
  }

 private:
  void add(const SceneBody& body) { ids_.push_back(scene_.add_body(desc_of(body))); }
  void replace_last() {
    scene_.remove_body(ids_.back());
    ids_.pop_back();
    add(bodies_.back());
  }
  void move(SceneBody& body) {
    for (Positions3* const x : {&body.x_t0, &body.x_t1}) {
      for (Vec3d& position : *x) position = std::isfinite(position.y) ? position : Vec3d{0.0, 0.0, 0.0};
    }
    if (random_.chance(0.3)) {
      body.x_t0 = body.x_t1;
      body.x_t1 = jittered(body.x_t1, 0.02, random_.bits());
      snap_to_grid(body.x_t1, 17);
    }
    if (random_.chance(0.1)) body.x_t1[random_.below(vertex_count(body))].y = NAN;
  }

  Random random_;
  Surgeon surgeon_{random_};
  Scene bodies_;
  softcd::Scene scene_;
  std::vector<Query> queries_;
  std::vector<BodyId> ids_;
};

SceneBody rough_cloth() {
  Mesh mesh = crumpled_cloth(9, 8, 0.25, 0.1, 7);
  snap_to_grid(mesh.positions, 17);
  return still(mesh, everything(0.03F));
}

Scene patients() {
  SoupOptions soup;
  soup.triangle_count = 50;
  soup.half_extent = 0.7;
  soup.largest = 0.5;
  soup.joined_share = 0.7;
  soup.degenerate_share = 0.2;
  Mesh ball = icosphere(1, 0.5);
  snap_to_grid(ball.positions, 17);
  return {rough_cloth(), still(triangle_soup(soup), everything(0.02F)), still(ball, everything(0.02F))};
}

TEST(ChangedMeshes, have_the_contacts_of_a_fresh_scene) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Hospital hospital(seed, patients());
    for (int step = 0; step < 30 && !HasFailure(); ++step) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << step);
      for (int i = step % 4; i >= 0; --i) hospital.operate();
      contacts += hospital.expect_contacts_as_anew();
    }
  }
  EXPECT_GT(contacts, 50'000U);
}

// A hub has so many triangles that its neighbours are not listed. It loses them one by one, and gets them back.
TEST(ChangedMeshes, around_a_vertex_of_many_triangles) {
  for (const NamedFan& fan : fans(120)) {
    SCOPED_TRACE(fan.name);
    SceneBody body = still(fan.mesh, everything(0.01F));
    const std::vector<Triangle> all = body.triangles;
    softcd::Scene scene(scene_options());
    Query query(scene, looking_for(Detection::dcd));
    const BodyId id = scene.add_body(desc_of(body));
    for (const std::size_t count : {all.size(), std::size_t{60}, std::size_t{7}, std::size_t{50}, all.size()}) {
      body.triangles.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
      scene.update_body(id, desc_of(body), {});
      scene.set_positions(id, body.x_t1);
      const std::map<std::uint32_t, std::uint32_t> same{{id.value, id.value}};
      EXPECT_EQ(all_touching(query.detect(), same),
                all_touching(detect_once({body}, test_options(Detection::dcd)), same));
    }
  }
}

// Rings of neighbours follow edges that come and go, numbered as all vertices of the scene are.
TEST(ChangedMeshes, keep_rings_of_neighbours_from_touching) {
  Scene bodies = patients();
  for (SceneBody& body : bodies) body.settings.neighbour_rings = 3;
  Hospital hospital(9, bodies);
  std::size_t contacts = 0;
  for (int step = 0; step < 30 && !HasFailure(); ++step) {
    SCOPED_TRACE(step);
    hospital.operate();
    contacts += hospital.expect_contacts_as_anew();
  }
  EXPECT_GT(contacts, 1000U);
}

// All triangles are read if a body has or had segments.
TEST(ChangedMeshes, with_segments_are_taken_anew) {
  const std::vector<Segment> ropes = {{{0, 20}}, {{33, 5}}, {{33, 60}}};
  SceneBody body = rough_cloth();
  softcd::Scene scene(scene_options());
  Query query(scene, looking_for(Detection::dcd));
  const BodyId id = scene.add_body(desc_of(body));
  std::uint32_t swapped = 0;
  for (const std::size_t segments : {3U, 3U, 0U, 0U, 0U, 1U, 0U, 0U}) {
    SCOPED_TRACE(swapped);
    const bool is_taken_anew = segments > 0 || !body.segments.empty();
    body.segments.assign(ropes.begin(), ropes.begin() + static_cast<std::ptrdiff_t>(segments));
    const std::vector<std::uint32_t> changed{swapped, swapped + 40};
    std::swap(body.triangles[changed[0]], body.triangles[changed[1]]);
    ++swapped;
    scene.update_body(id, desc_of(body), is_taken_anew ? std::vector<std::uint32_t>{} : changed);
    scene.set_positions(id, body.x_t1);
    const std::map<std::uint32_t, std::uint32_t> same{{id.value, id.value}};
    const auto found = all_touching(query.detect(), same);
    EXPECT_EQ(found, all_touching(detect_once({body}, test_options(Detection::dcd)), same));
    EXPECT_FALSE(found.empty());
  }
}

// A split makes a new vertex, which is at the split's place when the step starts. Features that pass through the new
// triangles on their path are found.
TEST(ChangedMeshes, are_continuous_across_a_change) {
  SceneBody sheet = still(grid_cloth(3, 3, 1.0), everything());
  SceneBody bullet = moving(moved(icosphere(0, 0.05), {0.7, 0.9, 0.5}),
                            translated(icosphere(0, 0.05).positions, {0.7, 0.9, -0.5}), everything());
  softcd::Scene scene(scene_options());
  Query query(scene, looking_for(Detection::ccd));
  const BodyId id = scene.add_body(desc_of(sheet));
  const BodyId other = scene.add_body(desc_of(bullet));
  scene.set_positions(id, sheet.x_t1);
  scene.set_positions(other, bullet.x_t0, bullet.x_t0);
  EXPECT_TRUE(query.detect().empty());

  std::vector<std::uint32_t> changed;
  for (std::uint32_t t = 0, all = static_cast<std::uint32_t>(sheet.triangles.size()); t < all; ++t) {
    const auto [a, b, c] = sheet.triangles[t].v;
    const std::uint32_t middle = vertex_count(sheet);
    sheet.x_t0.push_back((1.0 / 3.0) * (sheet.x_t0[a] + sheet.x_t0[b] + sheet.x_t0[c]));
    sheet.triangles[t] = {{a, b, middle}};
    sheet.triangles.push_back({{b, c, middle}});
    sheet.triangles.push_back({{c, a, middle}});
    changed.push_back(t);
    sheet.x_t1 = translated(sheet.x_t0, {0.0, 0.0, 0.1});
  }
  scene.update_body(id, desc_of(sheet), changed);
  scene.set_positions(id, sheet.x_t0, sheet.x_t1);
  scene.set_positions(other, bullet.x_t0, bullet.x_t1);
  const Span<const Contact> found = query.detect();
  const std::map<std::uint32_t, std::uint32_t> same{{id.value, 0}, {other.value, 1}};
  EXPECT_EQ(all_touching(found, same),
            all_touching(detect_once({sheet, bullet}, test_options(Detection::ccd)), {{0, 0}, {1, 1}}));
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Contact& contact) {
    return contact.kind == ContactKind::vertex_triangle && contact.body_b == id && contact.feature_b >= changed.size();
  }));
}

// Indices of vertex-triangle contacts are the mesh's, and a remaining edge keeps its index.
TEST(ChangedMeshes, keep_the_indices_of_what_stays) {
  SceneBody body = rough_cloth();
  softcd::Scene scene(scene_options());
  Query query(scene, looking_for(Detection::dcd));
  const BodyId id = scene.add_body(desc_of(body));
  scene.set_positions(id, body.x_t1);
  const auto edges_in = [](Span<const Contact> contacts) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges;
    for (const Contact& contact : contacts) {
      if (contact.kind != ContactKind::edge_edge) continue;
      edges[{contact.vertices[0], contact.vertices[1]}] = contact.feature_a;
      edges[{contact.vertices[2], contact.vertices[3]}] = contact.feature_b;
    }
    return edges;
  };
  const auto before = edges_in(query.detect());
  // The first edge of all is removed, so that all others would move up in a sorted order.
  body.triangles[0] = body.triangles.back();
  body.triangles.pop_back();
  const std::vector<std::uint32_t> changed{0};
  scene.update_body(id, desc_of(body), changed);
  scene.set_positions(id, body.x_t1);
  std::size_t kept = 0;
  for (const auto& [ends, edge] : edges_in(query.detect())) {
    const auto found = before.find(ends);
    if (found == before.end()) continue;
    EXPECT_EQ(found->second, edge);
    ++kept;
  }
  EXPECT_GT(kept, 100U);
}

class WrongChanges : public testing::Test {
 protected:
  WrongChanges() {
    id_ = scene_.add_body(desc_of(body_));
    scene_.set_positions(id_, body_.x_t1);
    const Span<const Contact> contacts = query_.detect();
    before_.assign(contacts.begin(), contacts.end());
  }
  ~WrongChanges() override { EXPECT_TRUE(identical(before_, query_.detect())) << "something has changed"; }

  std::string error_of_change(const std::vector<Triangle>& triangles, std::uint32_t vertices,
                              const std::vector<std::uint32_t>& changed) {
    return error_of([&] { scene_.update_body(id_, {triangles, vertices, body_.settings}, changed); });
  }

  SceneBody body_ = rough_cloth();
  softcd::Scene scene_{scene_options()};
  Query query_{scene_, looking_for(Detection::dcd)};
  BodyId id_;
  std::vector<Contact> before_;
};

TEST_F(WrongChanges, name_the_body_and_the_triangle) {
  using testing::AllOf;
  using testing::HasSubstr;
  std::vector<Triangle> triangles = body_.triangles;
  const auto all = static_cast<std::uint32_t>(triangles.size());
  EXPECT_THAT(error_of_change(triangles, vertex_count(body_), {3, all}),
              AllOf(HasSubstr("body 0"), HasSubstr("triangle " + std::to_string(all))));
  EXPECT_THAT(
      error_of_change(triangles, vertex_count(body_) - 1, {}),
      AllOf(HasSubstr("body 0"), HasSubstr("has not changed"), HasSubstr(std::to_string(vertex_count(body_) - 1))));
  triangles[5].v[1] = 4000;
  EXPECT_THAT(error_of_change(triangles, vertex_count(body_), {5}),
              AllOf(HasSubstr("body 0"), HasSubstr("triangle 5"), HasSubstr("4000")));
  triangles[5] = triangles[4];
  triangles.push_back({{0, 1, kNoIndex}});
  EXPECT_THAT(error_of_change(triangles, vertex_count(body_), {5}),
              AllOf(HasSubstr("body 0"), HasSubstr("triangle " + std::to_string(all))));
  triangles.pop_back();
  body_.settings.margin = -1.0F;
  EXPECT_THAT(error_of_change(triangles, vertex_count(body_), {5}), HasSubstr("margin"));
  EXPECT_THAT(error_of([&] { scene_.update_body(BodyId{7}, {}, {}); }), HasSubstr("body 7"));
}

}  // namespace
}  // namespace softcd::test
