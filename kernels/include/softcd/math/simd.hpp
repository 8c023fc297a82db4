#pragma once

/// SSE2, which every x86-64 processor has, for the few tests that take most of the CPU backend's time. Each has a twin
/// in namespace generic, for the device and for other processors. The twin returns the same for every input: smaller()
/// is _mm_min_ps and larger() is _mm_max_ps, operand by operand, signs of zeros and NaN included.
#if defined(__SSE2__) && !defined(__CUDA_ARCH__)
#define SOFTCD_SSE2
#include <emmintrin.h>
#endif
