#pragma once

#include <stdexcept>

#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Base class of all exceptions that softcd throws. Exceptions from a pair filter or a log callback pass through
/// unchanged. The text names the problem, its cause and the remedy. A call that throws leaves everything as it was, and
/// usable.
class SOFTCD_EXPORT Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller's data cannot be used: an index or an option is out of range, or arrays have unequal lengths.
class SOFTCD_EXPORT InvalidInput : public Error {
 public:
  using Error::Error;
};

/// Backend::cuda was requested but cannot be used: it was not built, no device exists, or the device failed.
class SOFTCD_EXPORT BackendError : public Error {
 public:
  using Error::Error;
};

/// A mesh, its positions or a detection needs more memory than there is.
class SOFTCD_EXPORT OutOfMemory : public Error {
 public:
  using Error::Error;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
