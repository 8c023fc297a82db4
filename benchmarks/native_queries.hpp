#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "queries.hpp"

namespace softcd::benchmarks {

/// Bullet's own continuous vertex-face test (bernsteinCCD in btSoftBodyInternals.h), with its structures filled in
/// advance. It returns no time of impact.
class NativeQueries {
 public:
  explicit NativeQueries(std::span<const test::Query> queries);
  ~NativeQueries();

  bool touches(std::size_t query) const;

 private:
  struct Prepared;
  std::vector<Prepared> prepared_;
};

}  // namespace softcd::benchmarks
