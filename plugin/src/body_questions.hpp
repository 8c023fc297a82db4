#pragma once

#include <cstdint>
#include <vector>

#include "softcd/core/spatial_query.hpp"
#include "softcd/stages/body_pairs.hpp"

namespace softcd::detail {

/// Returns the number of a body in the scene, whose bodies are in ascending order of ids; kNoIndex for BodyId().
std::uint32_t number_of(BodyId id, Span<const ProbedBody> bodies);

/// Questions about pairs of bodies, in the form that detectors take. Owned by ProbeCore.
class BodyQuestions {
 public:
  /// Prepares questions about pairs of bodies or BodyId(). Throws InvalidInput where they have 2^31 triangles or more.
  void prepare(Span<const ProbeBodies> asked, Span<const ProbedBody> bodies);

  Span<const BodiesQuestion> questions() const { return questions_; }
  std::uint64_t item_count() const { return item_count_; }

 private:
  std::vector<BodiesQuestion> questions_;
  std::uint64_t item_count_ = 0;
};

}  // namespace softcd::detail
