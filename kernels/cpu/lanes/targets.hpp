#pragma once

// Must come before Highway's headers. Registers whose length only a run tells cannot be members: processors with SVE
// use NEON. Single lanes do not pay: a processor without registers that Highway knows runs the generic code.
// NOLINTNEXTLINE(readability-identifier-naming): Highway reads it.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
