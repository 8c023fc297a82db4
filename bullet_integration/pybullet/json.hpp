#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>

#include "softcd/fields/fields.hpp"

namespace softcd::bullet::pybullet {

/// Returns the text as a string of JSON.
inline std::string quoted(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20) {
      result.append("\\u00").append({kDigits[code / 16], kDigits[code % 16]});
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

/// Returns an enumerator's name, a flag, or a number. JSON has no numbers that are not finite; they are null.
template <class Value>
std::string json_of_value(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return quoted(kEnumerators<Value>[static_cast<std::size_t>(value)]);
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "true" : "false";
  } else {
    if (!std::isfinite(static_cast<double>(value))) return "null";
    char text[64];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
  }
}

}  // namespace softcd::bullet::pybullet
