#pragma once

#include <stdexcept>

#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Every exception that softcd throws; those of a pair filter or a log callback pass through as they are. The text
/// names the problem, its cause and the remedy. A call that throws leaves everything as it was, and usable.
class SOFTCD_EXPORT Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller's data cannot be used: an index out of range, arrays of unequal length, an option out
/// of its range.
class SOFTCD_EXPORT InvalidInput : public Error {
 public:
  using Error::Error;
};

/// Backend::cuda was asked for and cannot be had: not built in, no device, or the device failed.
class SOFTCD_EXPORT BackendError : public Error {
 public:
  using Error::Error;
};

/// A mesh, its positions or a detection would need more memory than there is.
class SOFTCD_EXPORT OutOfMemory : public Error {
 public:
  using Error::Error;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
