#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "mesh_tools/mesh_io.hpp"

namespace softcd::mesh_tools {

// Parse a file's content. `file` is the name for messages.
Mesh read_ply(const std::string& file, std::string_view content);
Mesh read_obj(const std::string& file, std::string_view content);
Mesh read_gltf(const std::string& file, std::string_view content);  // a .glb file

// Vertex indices are 32 bits wide and kNoIndex is not one.
constexpr std::uint64_t kMaxVertexCount = kNoIndex;

constexpr std::string_view kBlanks = " \t\r\v\f";

// Cuts the first line off `text` and returns it without its end (\n or \r\n).
inline std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// Cuts the first word off `line` and returns it; empty when no word is left.
inline std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

// Reads the whole word, a number without a plus sign. Returns false if it is no number, or one that T cannot hold.
template <class T>
bool read_number(std::string_view word, T& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}
#ifndef __cpp_lib_to_chars  // libc++ before 20, whose from_chars reads no real numbers
inline bool read_number(std::string_view word, double& value) {
  std::string text(word);
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const double sign = word.starts_with('-') ? -1 : 1;
  const std::string_view name = std::string_view(text).substr(sign < 0 ? 1 : 0);
  if (name == "nan" || name == "inf" || name == "infinity") {
    using Limits = std::numeric_limits<double>;
    value = sign * (name == "nan" ? Limits::quiet_NaN() : Limits::infinity());
    return true;
  }
  if (word.starts_with('+') || name.find_first_not_of("0123456789.e+-") != std::string_view::npos) return false;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  return stream >> value && stream.peek() == std::char_traits<char>::eof();
}
#endif

// Returns the whole word as a number, or nothing, also where T cannot hold the number.
template <class T>
std::optional<T> parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  if (!read_number(word, value)) return std::nullopt;
  return value;
}

// Returns words from a foreign file in a form fit for a message: short and printable.
inline std::string in_quotes(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += (c >= ' ' && c <= '~') ? c : '?';
  return text + (word.size() > kLongest ? "...'" : "'");
}

// Splits a polygon into a fan of triangles around its first corner.
inline void append_fan(const std::vector<std::uint32_t>& corners, std::vector<Triangle>& triangles) {
  for (std::size_t i = 2; i < corners.size(); ++i) triangles.push_back({{corners[0], corners[i - 1], corners[i]}});
}

}  // namespace softcd::mesh_tools
