#include "settings.hpp"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "json.hpp"
#include "softcd/fields/settings.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// Calls visit(field) for each setting of clients.
template <class Visit>
void for_each_setting(const Visit& visit) {
  for_each_field<Settings>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) {
      if (is_for_clients(field.kName)) visit(field);
    }
  });
}

/// Returns the number of the word among `names`.
std::uint32_t choose(const std::string& word, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), word);
  if (found != names.end()) return static_cast<std::uint32_t>(found - names.begin());
  std::string problem = "'" + word + "' is none of";
  for (const std::string& name : names) problem += (&name == names.data() ? " " : ", ") + name;
  throw InvalidInput(problem + ".");
}

template <class Value>
void read(Value& value, const std::string& word) {
  if constexpr (std::is_enum_v<Value>) {
    value = Value{choose(word, {kEnumerators<Value>.begin(), kEnumerators<Value>.end()})};
  } else if constexpr (std::is_same_v<Value, bool>) {
    value = choose(word, {"False", "True"}) != 0;
  } else {
    std::istringstream in(word);
    const bool is_negative_count = std::is_unsigned_v<Value> && word.front() == '-';
    if (word.empty() || is_negative_count || !(in >> value) || !in.eof()) {
      throw InvalidInput("'" + word + (std::is_unsigned_v<Value> ? "' is no count." : "' is no number."));
    }
  }
}

/// Replaces all settings of clients by those of the preset.
void set_preset(Settings& settings, const std::string& word) {
  std::vector<std::string> names;
  for (const Preset& preset : kPresets) names.emplace_back(preset.name);
  const Settings preset = kPresets[choose(word, names)].value();
  for_each_setting([&](auto field) { field.of(settings) = field.of(preset); });
}

void set(Settings& settings, const std::string& name, const std::string& word) {
  if (name == "preset") return set_preset(settings, word);
  if (name == "on_error") {
    throw InvalidInput(
        "in PyBullet a step that fails always goes on with Bullet's own detection; read failed_steps of the report.");
  }
  bool is_known = false;
  for_each_setting([&](auto field) {
    if (name != field.kName) return;
    is_known = true;
    read(field.of(settings), word);
  });
  if (!is_known) throw InvalidInput("there is no such setting.");
}

/// Returns an object with what `value_of(field)` returns for each setting of clients.
template <class ValueOf>
std::string json_object(const ValueOf& value_of) {
  std::string text;
  for_each_setting([&](auto field) {
    text += (text.empty() ? "{\"" : ", \"") + std::string(field.kName) + "\": " + value_of(field);
  });
  return text + "}";
}

}  // namespace

Settings read_settings(std::istream& words, Settings settings) {
  for (std::string word; words >> word;) {
    const std::size_t sign = word.find('=');
    const std::string name = word.substr(0, sign);
    try {
      set(settings, name, sign == std::string::npos ? "" : word.substr(sign + 1));
    } catch (const InvalidInput& error) {
      throw InvalidInput(name + ": " + error.what());
    }
  }
  const std::string problem = problem_of(settings);
  if (!problem.empty()) throw InvalidInput(problem + ".");
  return settings;
}

std::string json_of(const Settings& settings) {
  return json_object([&](auto field) { return json_of_value(field.of(settings)); });
}

std::string json_of_all_settings() {
  return json_object([](auto field) {
    using Value = typename decltype(field)::Value;
    std::string text = "{";
    if constexpr (std::is_enum_v<Value>) {
      for (const char* name : kEnumerators<Value>) {
        text += (text == "{" ? "\"values\": [\"" : ", \"") + std::string(name) + "\"";
      }
      text += "], ";
    }
    for (const Preset& preset : kPresets) {
      const Settings settings = preset.value();
      text += (&preset == kPresets.data() ? "\"" : ", \"") + std::string(preset.name) +
              "\": " + json_of_value(field.of(settings));
    }
    return text + "}";
  });
}

}  // namespace softcd::bullet::pybullet
