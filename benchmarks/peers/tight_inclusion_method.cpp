#include <tight_inclusion/ccd.hpp>

#include "methods.hpp"

namespace softcd::peers {
namespace {

constexpr double kTolerance = 1e-6;
constexpr long kMostIterations = 1000000;

template <auto kTest>
bool touch(const Point& a_t0, const Point& b_t0, const Point& c_t0, const Point& d_t0, const Point& a_t1,
           const Point& b_t1, const Point& c_t1, const Point& d_t1) {
  double time = 0;
  double reached_tolerance = 0;
  const ticcd::Array3 no_scene = ticcd::Array3::Constant(-1);
  return kTest(a_t0, b_t0, c_t0, d_t0, a_t1, b_t1, c_t1, d_t1, no_scene, 0.0, time, kTolerance, 1.0, kMostIterations,
               reached_tolerance, ticcd::DEFAULT_NO_ZERO_TOI, ticcd::CCDRootFindingMethod::BREADTH_FIRST_SEARCH);
}

}  // namespace

const Method kTightInclusion{"Tight-Inclusion", touch<ticcd::vertexFaceCCD>, touch<ticcd::edgeEdgeCCD>};

}  // namespace softcd::peers
