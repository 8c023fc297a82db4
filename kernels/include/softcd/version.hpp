#pragma once

/// The version of these headers, and of the library that they belong to: CMake reads it here. While the major version
/// is 0, versions of different minor versions are incompatible.
#define SOFTCD_VERSION_MAJOR 0
#define SOFTCD_VERSION_MINOR 1
#define SOFTCD_VERSION_PATCH 0

/// To be compared: 10203 is version 1.2.3.
#define SOFTCD_VERSION (10000 * SOFTCD_VERSION_MAJOR + 100 * SOFTCD_VERSION_MINOR + SOFTCD_VERSION_PATCH)

/// "1.2.3".
#define SOFTCD_VERSION_STRING "0.1.0"

/// An inline namespace of all public names, one for compatible versions: what was compiled with the headers of one
/// version does not link with an incompatible library. Nobody writes it: softcd::Scene is softcd::v0_1::Scene.
#define SOFTCD_VERSION_NAMESPACE v0_1
