#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "commands.hpp"
#include "softcd/fields/settings.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// Returns the index of the word in `names`.
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

void set(Settings& settings, const std::string& name, const std::string& word) {
  bool is_known = false;
  for_each_field<Settings>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) {
      if (name != field.kName || !is_for_clients(name)) return;
      is_known = true;
      read(field.of(settings), word);
    }
  });
  if (!is_known) throw InvalidInput("there is no such setting.");
}

}  // namespace

Settings read_settings(std::istream& words) {
  Settings settings;
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

}  // namespace softcd::bullet::pybullet
