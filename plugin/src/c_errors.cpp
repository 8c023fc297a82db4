#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "c_interface.hpp"
#include "scene_core.hpp"

namespace softcd::c_interface {
namespace {

/// The text of the last error, ending with 0. A fixed array, so that writing to it cannot fail.
thread_local char last_error[1024] = "";

/// Stores the text, cut off after whole UTF-8 characters, and returns the status.
softcd_status report(softcd_status status, const char* text) noexcept {
  std::size_t length = std::min(std::strlen(text), sizeof last_error - 1);
  const auto is_inside_character = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80U;
  };
  while (length > 0 && is_inside_character(length)) --length;
  std::memcpy(last_error, text, length);
  last_error[length] = '\0';
  return status;
}

}  // namespace

softcd_status report_exception() noexcept {
  try {
    throw;
  } catch (const InvalidInput& error) {
    return report(SOFTCD_INVALID_INPUT, error.what());
  } catch (const BackendError& error) {
    return report(SOFTCD_BACKEND_ERROR, error.what());
  } catch (const OutOfMemory& error) {
    return report(SOFTCD_OUT_OF_MEMORY, error.what());
  } catch (const std::bad_alloc&) {
    return report(SOFTCD_OUT_OF_MEMORY, detail::kNoMemoryAtAll);
  } catch (const std::exception& error) {
    return report(SOFTCD_ERROR, error.what());
  } catch (...) {
    return report(SOFTCD_ERROR, "a callback has thrown something; callbacks of softcd.h must return.");
  }
}

void refuse_null(const char* argument) {
  throw InvalidInput(fmt::format("{} is NULL, but it is required.", argument));
}

void refuse_size(const char* argument, std::uint64_t size, std::size_t expected) {
  throw InvalidInput(
      fmt::format("{}: its struct_size is {} bytes, but softcd {} expects {}; use sizeof, and headers of this "
                  "version.",
                  argument, size, SOFTCD_VERSION_STRING, expected));
}

void refuse_choice(const char* argument, std::uint32_t value, std::uint32_t last) {
  throw InvalidInput(
      fmt::format("{} is {}, which is none of its values; they count from 0 to {}.", argument, value, last));
}

}  // namespace softcd::c_interface

uint32_t softcd_version() {
  return SOFTCD_VERSION;
}

const char* softcd_last_error() {
  return softcd::c_interface::last_error;
}
