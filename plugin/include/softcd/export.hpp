#pragma once

/// Marks what softcd's shared libraries show. All else in them is hidden.
#if defined(__GNUC__)
#define SOFTCD_EXPORT __attribute__((visibility("default")))
#else
#define SOFTCD_EXPORT
#endif
