#pragma once

#include <optional>

#include "queries.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {

/// Decides single queries through the public interface: one body that holds the two features and collides with itself.
class QueryDetector {
 public:
  /// Makes a detector. `margin` is the sum of both sides' margins.
  QueryDetector(ContactKind kind, const PipelineOptions& options, float margin = 0.0F);

  /// Returns the contact of the query's features, if they have one. Positions are given in double.
  std::optional<Contact> detect(const Query& query);

  const Statistics& statistics() const { return pipeline_.query.statistics(); }

 private:
  CollisionPipeline pipeline_;
  BodyId body_;
};

}  // namespace softcd::test
