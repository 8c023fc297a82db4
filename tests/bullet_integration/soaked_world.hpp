#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "random.hpp"

namespace softcd::test {

/// Counts of the events in a soaked world.
struct SoakCounts {
  std::uint64_t steps = 0;
  std::uint64_t watched_steps = 0;  ///< in which nothing may pass through anything
  std::uint64_t came = 0;           ///< bodies
  std::uint64_t went = 0;           ///< bodies
  std::uint64_t torn_links = 0;
  std::uint64_t refinements = 0;
  std::uint64_t settings = 0;  ///< that were set
  std::uint64_t contacts = 0;  ///< of vertices with faces
  std::uint64_t impacts = 0;
  std::uint64_t held_nodes = 0;
  std::uint64_t excused = 0;     ///< steps with pairs that were unavoidable or excepted
  std::uint64_t peak_bytes = 0;  ///< of a backend's memory
};

/// A small world in which sheets, balls and ropes come, fall upon each other and go, and are torn and refined.
/// Settings, filters and masses change, questions are asked, softcd is detached and attached. All is random, and the
/// same for the same number. The world never has more than so many bodies, of so many nodes.
class SoakedWorld {
 public:
  SoakedWorld(World world, std::uint64_t number);

  /// Changes something, then makes a step. Returns the first error as a sentence, or an empty text. Errors are
  /// positions that are not finite, steps in which a detector failed and, if crossings are prevented, intersections
  /// that the world's responses have not excepted.
  std::string step();

  const SoakCounts& counts() const { return counts_; }

 private:
  struct Member {
    btSoftBody* body;
    bool is_sheet = false;
    bool is_torn = false;
  };

  void change_something();
  void add_body();
  btSoftBody& place(std::unique_ptr<btSoftBody> body);
  std::unique_ptr<btSoftBody> make_body(Member& member);
  void wake_all();
  void remove(std::size_t member);
  void remove_strays();
  void remove_what_intersects();
  void tear(Member& sheet);
  void refine(Member& sheet);
  void change_body(Member& member);
  void change_settings();
  void toggle_box();
  void ask();

  bool is_watched() const;
  bool may_meet(const btSoftBody& a, const btSoftBody& b) const;
  std::vector<const btSoftBody*> bodies() const;
  std::string find_fault(bool is_judged);

  const World world_;
  Random random_;
  bullet::Settings settings_;
  btTriangleMesh ground_;
  AnySimulation simulation_;
  btSoftBody* pillar_ = nullptr;  ///< all of its nodes are fixed
  btRigidBody* box_ = nullptr;
  bool has_box_ = true;
  std::vector<Member> members_;      ///< without the pillar
  bool may_be_tangled_ = false;      ///< crossings have not been prevented since the last check
  bool have_nodes_changed_ = false;  ///< since the last step
  SoakCounts counts_;
};

}  // namespace softcd::test
