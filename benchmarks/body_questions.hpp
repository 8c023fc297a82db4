#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "every_pair.hpp"
#include "random.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

enum class BodyQuestion { distance, intersections, has_intersections, within, capsules, hulls, changes };

inline constexpr std::array<const char*, 7> kBodyQuestionNames = {"distance of two bodies",
                                                                  "intersections of two",
                                                                  "whether two intersect",
                                                                  "intersections within the mesh",
                                                                  "capsules",
                                                                  "hulls",
                                                                  "changes"};

struct BodyQuestionTime {
  BodyQuestion question;
  std::string name;              ///< of who answers
  std::size_t questions;         ///< of a repetition
  std::size_t answers;           ///< to all of them; of distances, of bodies that there are distances between
  double microseconds_each = 0;  ///< a question; of medians
};

/// What a Probe is asked about triangles of one mesh, of balls beside it, and of shapes near it.
class BodyQuestions {
 public:
  /// `extent` is the mesh's, half its box's diagonal. A hundredth of `questions` capsules, hulls and changes, at least
  /// 10, and a ten-thousandth of balls, at least 2. Keeps the mesh's references.
  BodyQuestions(const MeshView& mesh, double extent, std::size_t questions);

  std::vector<BodyQuestionTime> measure(Backend backend, int repetitions);
  /// Others' times for what there is an equal of, after measure(). Throws std::runtime_error where every pair of
  /// triangles has told something else.
  std::vector<BodyQuestionTime> measure_rivals(int repetitions) const;

  /// What is asked about, as a line.
  std::string description() const;

 private:
  /// Owns what a ProbeChange is made of.
  struct Change {
    std::vector<std::uint32_t> removed;
    std::vector<Triangle> added;
    std::vector<Vec3d> new_vertices;
  };
  struct Ball {
    std::vector<Triangle> triangles;
    std::vector<Vec3f> x;
  };
  /// By question, what of its first ones was answered.
  struct Answers {
    std::vector<double> distances;
    std::vector<std::size_t> intersections, changes;
  };

  void make_shapes(std::size_t count);
  void make_changes(std::size_t count);
  void make_balls(std::size_t count);
  std::vector<BodyQuestionTime> measure_mesh(Scene& scene, BodyId body, int repetitions);
  std::vector<BodyQuestionTime> measure_pairs(Scene& scene, BodyId body, int repetitions);
  Vec3d near_surface(double distance);
  void add_every_pair(std::vector<BodyQuestionTime>& times) const;
  void add_bullet(std::vector<BodyQuestionTime>& times, int repetitions) const;

  MeshView mesh_;
  double extent_;
  test::Random random_{2};
  std::vector<ProbeCapsule> capsules_;
  std::vector<std::vector<Vec3d>> hull_points_;
  std::vector<ProbeHull> hulls_;
  std::vector<Change> changes_;
  std::vector<Ball> balls_;
  Answers answers_;
};

}  // namespace softcd::benchmarks
