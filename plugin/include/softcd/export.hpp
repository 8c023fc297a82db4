#pragma once

/// Marks the names that softcd's shared library exports. All other names are hidden. On Windows, CMake defines
/// SOFTCD_SHARED for the shared library and for its users, and softcd_EXPORTS for the library alone.
#if defined(_WIN32) && defined(softcd_EXPORTS)
#define SOFTCD_EXPORT __declspec(dllexport)
#elif defined(_WIN32) && defined(SOFTCD_SHARED)
#define SOFTCD_EXPORT __declspec(dllimport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define SOFTCD_EXPORT __attribute__((visibility("default")))
#else
#define SOFTCD_EXPORT
#endif
