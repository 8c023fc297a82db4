#pragma once

#include "generic_kernels.cuh"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/feature_pairs.hpp"
#include "softcd/stages/pair_tests.hpp"

/// Tuning parameters of single stages' kernels, measured on an H200.
namespace softcd::cuda {

/// These kernels wait for memory, and would otherwise use too many registers.
template <class Control>
constexpr int kResidentBlocks<TestPair<Control, false>> = 4;
template <class Control>
constexpr int kResidentBlocks<TestPair<Control, true>> = 3;
template <ContactKind kKind, bool kSwept>
constexpr int kResidentBlocks<ExpandPair<kKind, kSwept>> = 4;
template <ContactKind kKind, bool kSwept>
constexpr int kResidentBlocks<TestNeighbours<kKind, kSwept>> = 4;
template <ContactKind kKind, class T>
constexpr int kResidentBlocks<TestMotion<kKind, T>> = 2;
template <ContactKind kKind>
constexpr int kResidentBlocks<TestApproach<kKind>> = 2;

/// Large triangles have a hundred times the rows of others, and are often neighbours.
template <>
constexpr std::uint32_t kItemsAtOnce<RegisterTriangle> = 64;

}  // namespace softcd::cuda
