#pragma once

#include <string>
#include <string_view>

namespace softcd::demo {

/// Returns the SHA-256 of the bytes in 64 hexadecimal digits, as the program sha256sum prints it. Throws
/// std::runtime_error where OpenSSL has no SHA-256.
std::string sha256(std::string_view bytes);

}  // namespace softcd::demo
