#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "softcd/fields/options.hpp"

/// Names of the library's choices in the programs' command lines.
namespace softcd::demo {

template <class Value>
struct Choice {
  const char* name;
  Value value;
};

/// An enumerator as a word of a command line: "closest-feature" for `closest_feature`, "auto" for `automatic`.
template <auto kEnumerator>
inline constexpr auto kWord = [] {
  auto word = kNameInSource<kEnumerator>;
  const bool is_automatic = std::string_view(word.data()) == "automatic";
  for (char& c : word) c = c == '_' ? '-' : c;
  if (is_automatic) word[std::string_view("auto").size()] = '\0';
  return word;
}();

template <class Enum, std::uint32_t... kValue>
constexpr std::array<Choice<Enum>, sizeof...(kValue)> choices_of(
    std::integer_sequence<std::uint32_t, kValue...> /*values*/) {
  return {{{kWord<Enum{kValue}>.data(), Enum{kValue}}...}};
}
/// All values of an enumeration by their words.
template <class Enum>
inline constexpr auto kChoices =
    choices_of<Enum>(std::make_integer_sequence<std::uint32_t, kEnumerators<Enum>.size()>());
template <>
inline constexpr std::array<Choice<bool>, 2> kChoices<bool> = {{{"on", true}, {"off", false}}};

template <class Choices>
std::string join_names(const Choices& choices, const char* separator) {
  std::string names;
  for (const auto& choice : choices) names += (names.empty() ? "" : separator) + std::string(choice.name);
  return names;
}

template <class Choices, class Value>
const char* name_of(const Choices& choices, Value value) {
  const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.value == value; });
  return found == choices.end() ? "?" : found->name;
}

template <class Enum>
const char* name_of(Enum value) {
  return name_of(kChoices<Enum>, value);
}

/// Returns the choice of that name. Throws CLI::ValidationError when there is none.
template <class Choices>
auto value_of(const Choices& choices, const std::string& word, const std::string& option) {
  const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.name == word; });
  if (found == choices.end()) {
    throw CLI::ValidationError(option, fmt::format("'{}' is not one of {}", word, join_names(choices, ", ")));
  }
  return found->value;
}

/// Adds an option that takes one of the choices' names. `target` holds the default. `target` and `choices` must outlive
/// the parsing.
template <class Choices, class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Choices& choices, Value& target,
                        const std::string& description) {
  const auto choose = [&choices, &target, name](const std::string& word) { target = value_of(choices, word, name); };
  return app.add_option_function<std::string>(name, choose, description)
      ->option_text(fmt::format("{} [{}]", join_names(choices, "|"), name_of(choices, target)));
}

/// Adds an option that takes one word of an enumeration, or on and off.
template <class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& target, const std::string& description) {
  return add_choice(app, name, kChoices<Value>, target, description);
}

/// Adds an option that takes several names, one after the other or separated by commas.
template <class Choices, class Value>
CLI::Option* add_choices(CLI::App& app, const std::string& name, const Choices& choices, std::vector<Value>& targets,
                         const std::string& description) {
  const auto choose = [&choices, &targets, name](const std::vector<std::string>& words) {
    targets.clear();
    for (const std::string& word : words) targets.push_back(value_of(choices, word, name));
  };
  std::string defaults;
  for (const Value& value : targets) defaults += (defaults.empty() ? "" : ",") + std::string(name_of(choices, value));
  return app.add_option_function<std::vector<std::string>>(name, choose, description)
      ->delimiter(',')
      ->option_text(fmt::format("{}... [{}]", join_names(choices, "|"), defaults));
}

/// Adds an option that takes several words of an enumeration.
template <class Enum>
CLI::Option* add_choices(CLI::App& app, const std::string& name, std::vector<Enum>& targets,
                         const std::string& description) {
  return add_choices(app, name, kChoices<Enum>, targets, description);
}

}  // namespace softcd::demo
