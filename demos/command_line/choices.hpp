#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <string>

#include "softcd/softcd.hpp"

/// What the programs' command lines call the library's choices.
namespace softcd::demo {

template <class Value>
struct Choice {
  const char* name;
  Value value;
};

inline constexpr std::array<Choice<Backend>, 3> kBackends = {
    {{"auto", Backend::automatic}, {"cpu", Backend::cpu}, {"cuda", Backend::cuda}}};
inline constexpr std::array<Choice<Detection>, 2> kDetections = {{{"dcd", Detection::dcd}, {"ccd", Detection::ccd}}};
inline constexpr std::array<Choice<Accuracy>, 2> kAccuracies = {
    {{"fast", Accuracy::fast}, {"precise", Accuracy::precise}}};
inline constexpr std::array<Choice<BroadPhase>, 3> kBroadPhases = {
    {{"exact", BroadPhase::exact}, {"paper", BroadPhase::paper}, {"uniform", BroadPhase::uniform}}};
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

/// An option that takes one of the choices' names. `target` holds the default; it and `choices` outlive the parsing.
template <class Choices, class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Choices& choices, Value& target,
                        const std::string& description) {
  const auto choose = [&choices, &target, name](const std::string& word) {
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.name == word; });
    if (found == choices.end()) {
      throw CLI::ValidationError(name, fmt::format("'{}' is not one of {}", word, join_names(choices, ", ")));
    }
    target = found->value;
  };
  return app.add_option_function<std::string>(name, choose, description)
      ->option_text(fmt::format("{} [{}]", join_names(choices, "|"), name_of(choices, target)));
}

}  // namespace softcd::demo
