#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "command_line/choices.hpp"

/// Flags for members of the library's options: name, words, range, default and help come from their lists of fields.
namespace softcd::demo {

/// Returns "--cell-size-factor" for "cell_size_factor".
inline std::string flag_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

/// Breaks the text into lines, as CLI11 does not.
inline std::string in_lines(const std::string& text) {
  constexpr std::size_t kLongestLine = 94;
  std::istringstream words(text);
  std::string lines;
  std::size_t length = 0;
  for (std::string word; words >> word; length += word.size() + 1) {
    const bool fits = length + word.size() <= kLongestLine;
    if (!fits) length = 0;
    lines += (lines.empty() ? "" : fits ? " " : "\n") + word;
  }
  return lines;
}

/// Help texts name enumerators as the source does: replaces these names by the flag's words.
template <class Enum, std::uint32_t... kValue>
std::string in_words(std::string help, std::integer_sequence<std::uint32_t, kValue...> /*values*/) {
  const auto replace = [&help](std::string_view name, std::string_view word) {
    for (std::size_t at = help.find(name); at != std::string::npos; at = help.find(name, at + word.size())) {
      help.replace(at, name.size(), word);
    }
  };
  (replace(kNameInSource<Enum{kValue}>.data(), kWord<Enum{kValue}>.data()), ...);
  return help;
}

inline std::string refuse_sign(const std::string& number) {
  return number.starts_with('-') ? "must not be negative" : "";
}

/// Adds a flag that sets a number. 64 bits count bytes, and take units.
template <class AnyField, class Value>
void add_number(CLI::App& app, AnyField field, Value& target, const std::string& help) {
  constexpr bool kIsSize = std::is_same_v<Value, std::uint64_t>;
  const std::string flag = flag_of(field.kName);
  const auto set = [field, flag, &target](const Value& value) {
    const std::string problem = problem_of_value(field, value);
    if (!problem.empty()) throw CLI::ValidationError(flag, problem);
    target = value;
  };
  CLI::Option* const option = app.add_option_function<Value>(
      flag, set, in_lines(kIsSize ? help + ". Also with K, M, G (1000) or KiB, MiB, GiB (1024)" : help));
  option->option_text(fmt::format("{} [{}]", kIsSize ? "BYTES" : std::is_integral_v<Value> ? "N" : "X", target));
  if constexpr (kIsSize) option->transform(CLI::AsSizeValue(/*kb_is_1000=*/true));
  // Checked before units are read: that would turn -1 into 2^64 - 1.
  if constexpr (std::is_unsigned_v<Value>) option->transform(CLI::Validator(refuse_sign, ""));
}

/// Adds the flag of one member.
template <class AnyField, class Struct>
void add_field(CLI::App& app, AnyField field, Struct& object) {
  static_assert(field.kHelp != nullptr, "every option has a help text");
  auto& target = field.of(object);
  using Value = typename AnyField::Value;
  if constexpr (std::is_enum_v<Value>) {
    using Values = std::make_integer_sequence<std::uint32_t, kEnumerators<Value>.size()>;
    add_choice(app, flag_of(field.kName), target, in_lines(in_words<Value>(field.kHelp, Values())));
  } else if constexpr (std::is_same_v<Value, bool>) {
    add_choice(app, flag_of(field.kName), target, in_lines(field.kHelp));
  } else {
    add_number(app, field, target, field.kHelp);
  }
}

/// Whether a member of this type has a flag: not callbacks, pointers and communicators.
template <class Value>
inline constexpr bool kHasFlag = std::is_enum_v<Value> || std::is_arithmetic_v<Value>;

/// Calls visit(field) for each member that has a flag, but for those that are named.
template <class Struct, class Visit>
void for_each_flag(std::initializer_list<std::string_view> left_out, const Visit& visit) {
  for_each_field<Struct>([&](auto field) {
    if constexpr (kHasFlag<typename decltype(field)::Value>) {
      if (std::find(left_out.begin(), left_out.end(), field.kName) == left_out.end()) visit(field);
    }
  });
}

/// Adds a flag for each member, but for those that are named. `object` holds the defaults, and must outlive the
/// parsing.
template <class Struct>
void add_fields(CLI::App& app, Struct& object, std::initializer_list<std::string_view> left_out = {}) {
  for_each_flag<Struct>(left_out, [&](auto field) { add_field(app, field, object); });
}

}  // namespace softcd::demo
