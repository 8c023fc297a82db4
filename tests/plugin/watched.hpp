#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "scene_parts.hpp"

/// A scene whose queries keep their pairs, for tests that they find the same contacts as detections of their own.
namespace softcd::test {

/// Returns the contacts of a scene's first detection.
inline std::vector<Contact> detect_anew(const Scene& bodies, const QueryOptions& options, const PairFilter& filter) {
  softcd::Scene scene(scene_options());
  for (const SceneBody& body : bodies) scene.set_positions(scene.add_body(desc_of(body)), body.x_t0, body.x_t1);
  Query query(scene, options);
  query.set_pair_filter(filter);
  std::vector<Contact> contacts = copy_of(query.detect());
  EXPECT_FALSE(query.statistics().reused_pairs);
  return contacts;
}

/// A scene, and queries that keep their pairs.
class Watched {
 public:
  explicit Watched(Scene bodies) : bodies_(std::move(bodies)) {
    for (const SceneBody& body : bodies_) add(body);
  }

  Query& query(const QueryOptions& options) {
    queries_.push_back(std::make_unique<Query>(*scene_, options));
    return *queries_.back();
  }

  softcd::Scene& scene() { return *scene_; }
  SceneBody& body(std::size_t i) { return bodies_[i]; }
  BodyId id(std::size_t i) const { return ids_[i]; }
  std::size_t size() const { return bodies_.size(); }

  /// Sets the body's present positions.
  void move(std::size_t i) { scene_->set_positions(ids_[i], bodies_[i].x_t0, bodies_[i].x_t1); }
  void move_all() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) move(i);
  }
  void set_settings(std::size_t i) { scene_->set_settings(ids_[i], bodies_[i].settings); }
  void update(std::size_t i) {
    scene_->update_body(ids_[i], desc_of(bodies_[i]));
    move(i);
  }
  void replace_last(const SceneBody& body) {
    scene_->remove_body(ids_.back());
    ids_.pop_back();
    bodies_.back() = body;
    add(body);
  }

  /// Expects a query's contacts to be those of a new scene. Returns their number.
  std::size_t expect_contacts(Query& query, const PairFilter& filter = {}) {
    query.set_pair_filter(filter);
    const Span<const Contact> found = query.detect();
    const std::vector<Contact> expected = detect_anew(bodies_, query.options(), filter_by_place(filter));
    // Ids differ where bodies were removed.
    const std::vector<FeaturePair> places = places_of(found);
    EXPECT_EQ(places, features_of(expected));
    EXPECT_TRUE(ids_.back().value + 1 > ids_.size() || identical(expected, found));
    return expected.size();
  }

 private:
  void add(const SceneBody& body) {
    ids_.push_back(scene_->add_body(desc_of(body)));
    scene_->set_positions(ids_.back(), body.x_t0, body.x_t1);
  }
  std::uint32_t place_of(std::uint32_t id) const {
    std::uint32_t place = 0;
    while (ids_[place].value != id) ++place;
    return place;
  }
  PairFilter filter_by_place(const PairFilter& filter) const {
    if (!filter) return {};
    return [&](BodyId a, BodyId b) { return filter(ids_[a.value], ids_[b.value]); };
  }
  std::vector<FeaturePair> places_of(Span<const Contact> contacts) const {
    std::vector<FeaturePair> places = features_of(contacts);
    for (FeaturePair& pair : places) {
      pair.body_a = place_of(pair.body_a);
      pair.body_b = place_of(pair.body_b);
    }
    return places;
  }

  Scene bodies_;
  std::unique_ptr<softcd::Scene> scene_ = std::make_unique<softcd::Scene>(scene_options());
  std::vector<BodyId> ids_;
  std::vector<std::unique_ptr<Query>> queries_;
};

/// Returns the first of equal detections that kept pairs serve. The first one keeps nothing, the second keeps volumes,
/// and the third finds that they still hold. It keeps its pairs, where counts are known at once; else the next one
/// does.
inline int first_served() {
  return backend_under_test() == Backend::cpu ? 3 : 4;
}

inline SceneBody cloth(double height, std::uint64_t seed, float margin = 0.05F) {
  Mesh mesh = crumpled_cloth(12, 10, 0.2, 0.15, seed);
  mesh.positions = translated(mesh.positions, {0.0, 0.0, height});
  snap_to_grid(mesh.positions, 17);
  return still(mesh, everything(margin));
}

inline Scene two_cloths() {
  return {cloth(0.0, 1), cloth(0.1, 2)};
}

/// Makes detections until all pairs are kept.
inline void rest(Watched& watched, Query& query) {
  for (int look = 0; look < 5; ++look) watched.expect_contacts(query);
  ASSERT_TRUE(query.statistics().reused_pairs);
}

}  // namespace softcd::test
