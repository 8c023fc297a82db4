#pragma once

#include <Eigen/Core>

/// Tests of one query, with the arguments of CCD-Wrapper's vertexFaceCCD and edgeEdgeCCD: a vertex and a face's
/// vertices, or two edges' vertices, at the start, then at the end. They return whether the features touch on straight
/// paths.
namespace softcd::peers {

using Point = Eigen::Vector3d;

using Test = bool (*)(const Point&, const Point&, const Point&, const Point&, const Point&, const Point&, const Point&,
                      const Point&);

struct Method {
  const char* name;
  Test vertex_face, edge_edge;
};

/// softcd's test of `precise` and `conservative`.
extern const Method kSoftcd;
/// With the values that its authors suggest: a tolerance of 1e-6 and at most a million iterations.
extern const Method kTightInclusion;
/// The time-dependent solver with boxes along the features, as in its authors' benchmark.
extern const Method kTdib;

}  // namespace softcd::peers
