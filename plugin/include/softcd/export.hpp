#pragma once

/// Marks the names that softcd's shared libraries export. All other names are hidden.
#if defined(__GNUC__)
#define SOFTCD_EXPORT __attribute__((visibility("default")))
#else
#define SOFTCD_EXPORT
#endif
