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
  std::string name;              ///< of the library that answers
  std::size_t questions;         ///< in a repetition
  std::size_t answers;           ///< to all of them; for distances, the number of pairs of bodies with a distance
  double microseconds_each = 0;  ///< for one question, from the medians
};

/// Measures a Probe's questions about triangles of one mesh, balls beside it, and shapes near it.
class BodyQuestions {
 public:
  /// `extent` is half the diagonal of the mesh's box. The number of capsules, hulls and changes is a hundredth of
  /// `questions`, at least 10; that of balls is a ten-thousandth, at least 2. Keeps the mesh's references.
  BodyQuestions(const MeshView& mesh, double extent, std::size_t questions);

  std::vector<BodyQuestionTime> measure(Backend backend, int repetitions);
  /// Returns the times of other libraries and methods for the same questions. Call it after measure(). Throws
  /// std::runtime_error where comparing every pair of triangles gave other results.
  std::vector<BodyQuestionTime> measure_rivals(int repetitions) const;

  /// Returns a line that describes the questions.
  std::string description() const;

 private:
  /// Owns the data of a ProbeChange.
  struct Change {
    std::vector<std::uint32_t> removed;
    std::vector<Triangle> added;
    std::vector<Vec3d> new_vertices;
  };
  struct Ball {
    std::vector<Triangle> triangles;
    std::vector<Vec3f> x;
  };
  /// The results of the first questions, by kind of question.
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
