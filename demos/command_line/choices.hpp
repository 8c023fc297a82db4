#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "softcd/fields/options.hpp"

/// Names of the library's choices in the programs' command lines.
namespace softcd::demo {

template <class Value>
struct Choice {
  const char* name;
  Value value;
};

/// Returns an enumeration's values by their names, with "auto" for `automatic`.
template <class Enum>
constexpr auto choices_of() {
  std::array<Choice<Enum>, kEnumerators<Enum>.size()> choices{};
  for (std::uint32_t i = 0; i < choices.size(); ++i) {
    const char* const name = kEnumerators<Enum>[i];
    choices[i] = {name == std::string_view("automatic") ? "auto" : name, Enum{i}};
  }
  return choices;
}

inline constexpr auto kBackends = choices_of<Backend>();
inline constexpr auto kDetections = choices_of<Detection>();
inline constexpr auto kAccuracies = choices_of<Accuracy>();
inline constexpr auto kBroadPhases = choices_of<BroadPhase>();
inline constexpr std::array<Choice<bool>, 2> kOnOff = {{{"on", true}, {"off", false}}};

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

}  // namespace softcd::demo
