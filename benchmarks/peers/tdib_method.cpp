#include <linearSolver.h>

#include "methods.hpp"

namespace softcd::peers {
namespace {

constexpr double kTolerance = 1e-6;

bool vertex_face(const Point& v_t0, const Point& f0_t0, const Point& f1_t0, const Point& f2_t0, const Point& v_t1,
                 const Point& f0_t1, const Point& f1_t1, const Point& f2_t1) {
  const Face face(std::array<Vector3d, 3>{f0_t0, f1_t0, f2_t0});
  const Face motion(std::array<Vector3d, 3>{f0_t1 - f0_t0, f1_t1 - f1_t0, f2_t1 - f2_t0});
  Array2d place(0, 0);
  return LinearSolverTD::solveVFTest(v_t0, v_t1 - v_t0, face, motion, place, BoundingBoxType::OBB, 1, kTolerance) >= 0;
}

bool edge_edge(const Point& a0_t0, const Point& a1_t0, const Point& b0_t0, const Point& b1_t0, const Point& a0_t1,
               const Point& a1_t1, const Point& b0_t1, const Point& b1_t1) {
  const Edge a(a0_t0, a1_t0), b(b0_t0, b1_t0);
  const Edge a_motion(a0_t1 - a0_t0, a1_t1 - a1_t0), b_motion(b0_t1 - b0_t0, b1_t1 - b1_t0);
  double on_a = 0;
  double on_b = 0;
  return LinearSolverTD::solveEETest(a, a_motion, b, b_motion, on_a, on_b, BoundingBoxType::OBB, 1, kTolerance) >= 0;
}

}  // namespace

const Method kTdib{"TDIB-CCD", vertex_face, edge_edge};

}  // namespace softcd::peers
