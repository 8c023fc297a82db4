#pragma once

/// SSE2, part of every x86-64, for the few tests that the CPU backend spends its time on. Each has a twin in namespace
/// generic, for the device and for other processors, that returns the same for every input: smaller() is _mm_min_ps and
/// larger() is _mm_max_ps, operand by operand, signs of zeros and NaN included.
#if defined(__SSE2__) && !defined(__CUDA_ARCH__)
#define SOFTCD_SSE2
#include <emmintrin.h>
#endif
