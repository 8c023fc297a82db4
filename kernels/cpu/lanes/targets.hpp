#pragma once

// Must come before Highway's headers. Registers whose length only a run tells cannot be members: processors with SVE
// use NEON. Single lanes do not pay: a processor without registers that Highway knows runs the generic code.
// NOLINTBEGIN(readability-identifier-naming): Highway reads it.
#define SOFTCD_UNSIZED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#if defined(__MINGW32__) && !defined(__clang__)
// g++ for Windows spills registers of 32 bytes to a stack that is aligned to 16, with instructions that fault there.
// All x86 targets with such registers have bits below that of SSE4.
#define HWY_DISABLED_TARGETS (SOFTCD_UNSIZED_TARGETS | (HWY_SSE4 - 1))
#else
#define HWY_DISABLED_TARGETS SOFTCD_UNSIZED_TARGETS
#endif
// NOLINTEND(readability-identifier-naming)
