#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "../../bullet_integration/pybullet/settings.hpp"
#include "softcd/fields/settings.hpp"

namespace softcd::bullet {
namespace {

Settings read(const std::string& text) {
  std::istringstream words(text);
  return pybullet::read_settings(words);
}

std::string problem_with(const std::string& text) {
  try {
    read(text);
    return {};
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

/// A value that is not the default, as a word.
template <class Value>
std::string other_word(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return kEnumerators<Value>[value == Value{} ? 1 : 0];
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "False" : "True";
  } else {
    return "2";
  }
}

TEST(Settings, all_can_be_set_by_clients_of_pybullet_but_for_those_that_are_said) {
  int read_settings = 0;
  for_each_field<Settings>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) {
      if (!pybullet::is_for_clients(field.kName)) return;
      Settings by_default;
      Settings set = read(field.kName + ("=" + other_word(field.of(by_default))));
      EXPECT_NE(field.of(set), field.of(by_default)) << field.kName;
      ++read_settings;
    } else {
      EXPECT_FALSE(pybullet::is_for_clients(field.kName)) << field.kName;
    }
  });
  EXPECT_EQ(read_settings, 16);
}

TEST(Settings, of_a_preset_are_those_of_its_function_and_may_change) {
  EXPECT_EQ(read("preset=safe").detection, Detection::ccd);
  EXPECT_EQ(read("preset=safe").contacts, Settings::safe().contacts);
  EXPECT_EQ(read("preset=fast").accuracy, Settings::fast().accuracy);
  EXPECT_EQ(read("preset=safe detection=dcd").detection, Detection::dcd);
  EXPECT_EQ(read("preset=safe detection=dcd").edge_contacts, EdgeContacts::respond);
  EXPECT_EQ(read("preset=safe preset=balanced").edge_contacts, EdgeContacts::automatic);
  EXPECT_EQ(problem_with("preset=best"), "preset: 'best' is none of fast, balanced, safe.");
}

TEST(Settings, that_are_not_named_stay) {
  Settings before;
  before.detection = Detection::ccd;
  before.log = [](LogLevel, std::string_view) {};
  std::istringstream words("edge_contacts=report");
  const Settings after = pybullet::read_settings(words, before);
  EXPECT_EQ(after.detection, Detection::ccd);
  EXPECT_EQ(after.edge_contacts, EdgeContacts::report);
  EXPECT_TRUE(after.log);
}

TEST(Settings, are_shown_as_json_with_their_words_and_presets) {
  const std::string now = pybullet::json_of(Settings::safe());
  EXPECT_EQ(now.substr(0, 46), R"({"backend": "automatic", "detection": "ccd", ")");
  EXPECT_NE(now.find(R"("cell_size_factor": 0, "reuse_pairs": true)"), std::string::npos) << now;
  const std::string all = pybullet::json_of_all_settings();
  EXPECT_NE(all.find(R"("detection": {"values": ["dcd", "ccd"], "fast": "dcd", "balanced": "dcd", "safe": "ccd"})"),
            std::string::npos)
      << all;
  EXPECT_EQ(all.find("on_error"), std::string::npos);
}

TEST(Settings, all_of_clients_have_types_in_python) {
  std::ifstream source(SOFTCD_SOURCE_DIR "/python/softcd/_bullet_settings.py");
  const std::string text{std::istreambuf_iterator<char>(source), {}};
  for_each_field<Settings>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if (!pybullet::is_for_clients(field.kName)) return;
    const std::size_t place = text.find(std::string("\n    ") + field.kName + ": ");
    ASSERT_NE(place, std::string::npos) << field.kName;
    const std::string type = text.substr(place, text.find('\n', place + 1) - place);
    if constexpr (std::is_enum_v<Value>) {
      for (const char* value : kEnumerators<Value>) {
        EXPECT_NE(type.find(std::string("\"") + value + "\""), std::string::npos) << field.kName << " " << value;
      }
    }
  });
}

TEST(Settings, of_clients_that_are_wrong_are_named) {
  EXPECT_EQ(problem_with("detection=often"), "detection: 'often' is none of dcd, ccd.");
  EXPECT_EQ(problem_with("rigid_meshes=0"), "rigid_meshes: '0' is none of False, True.");
  EXPECT_EQ(problem_with("speed=3"), "speed: there is no such setting.");
  EXPECT_EQ(problem_with("on_error=throw_error").substr(0, 46), "on_error: in PyBullet a step that fails always");
  EXPECT_EQ(problem_with("contacts_per_node=-1"), "contacts_per_node: '-1' is no count.");
  EXPECT_EQ(problem_with("contacts_per_node"), "contacts_per_node: '' is no count.");
  EXPECT_EQ(problem_with("cell_size_factor=x"), "cell_size_factor: 'x' is no number.");
  EXPECT_EQ(problem_with("cell_size_factor=1000"), "cell_size_factor is 1000, but must be 0, or 0.1 to 100.");
  EXPECT_EQ(problem_with("cell_size_factor=1.5 convex_shapes=faces_and_edges"), "");
}

}  // namespace
}  // namespace softcd::bullet
