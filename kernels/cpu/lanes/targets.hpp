#pragma once

// Before Highway's headers. Registers of a length that only a run tells cannot be members: processors with SVE use
// NEON. One lane, where a processor has no registers that Highway knows, is not worth it: there the generic code runs.
// NOLINTNEXTLINE(readability-identifier-naming): Highway reads it.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
