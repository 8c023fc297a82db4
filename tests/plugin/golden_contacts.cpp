#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>
#include <cstring>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "each_target.hpp"
#include "golden_scenes.hpp"
#include "softcd/core/fnv.hpp"
#include "softcd/core/parallel.hpp"

// Contacts are the same bytes from version to version. A different hash is a defect, unless the change is intended and
// explained; then it is replaced. Compilers, their options, processors, threads and backends make no difference, as far
// as tests/golden.sh tries them.
namespace softcd::test {
namespace {

struct Golden {
  GoldenScene scene;
  std::uint64_t hash;  ///< of the contacts of all kWays
};

constexpr Golden kGolden[] = {
    {{"soups", soups}, 0xd04f9514e43bab58U},
    {{"roughened_soups", roughened_soups}, 0xf30e8a4abf5c6eb5U},
    {{"distant_soups", distant_soups}, 0xe1dadd4a355a6eabU},
    {{"strays", strays}, 0x2740cb4ebe1a50d9U},
    {{"tiny_soups", tiny_soups}, 0xc3fb109aca90863cU},
    {{"huge_soups", huge_soups}, 0x50fb46f7450eadd6U},
    {{"needles", needles}, 0x4ea22f504ed0df7aU},
    {{"degenerate_triangles", degenerate_triangles}, 0x0e5b6509b51b5e0aU},
    {{"uneven_soups", uneven_soups}, 0x2db41645d4bfdb2fU},
    {{"ball_through_sheets", ball_through_sheets}, 0x0f9f4b4e1c222c0fU},
    {{"everted_ball", everted_ball}, 0x7aa6a6afbb1cbb06U},
    {{"coincident_balls", coincident_balls}, 0x127273a940553249U},
    {{"coplanar_sheets", coplanar_sheets}, 0x653af17235cb3340U},
    {{"accordion", accordion}, 0x263bfbc1ba6f0ceeU},
    {{"turning_stars", turning_stars}, 0x8069fbd983f40a66U},
    {{"hubs", hubs}, 0x9e40dc7e8915a95dU},
    {{"filtered_soups", filtered_soups}, 0xa17df6083a6a196cU},
    {{"kinematic_ground", kinematic_ground}, 0x066f46f4598315f3U},
    {{"unequal_margins", unequal_margins}, 0xbea5346efc5e3516U},
    {{"points_and_segments", points_and_segments}, 0xcd5fb0b12e0e9df9U},
    {{"rope_and_fringes", rope_and_fringes}, 0xf9e997060e462ac1U},
};

struct Way {
  const char* name;
  Detection detection;
  Accuracy accuracy;
  ContactRule rule = ContactRule::distance;
  float motion_margin = 0.0F;
};

constexpr Way kWays[] = {
    {"dcd fast", Detection::dcd, Accuracy::fast},
    {"dcd precise", Detection::dcd, Accuracy::precise},
    {"dcd conservative", Detection::dcd, Accuracy::conservative},
    {"dcd slab", Detection::dcd, Accuracy::precise, ContactRule::slab},
    {"dcd motion margin", Detection::dcd, Accuracy::precise, ContactRule::distance, 0.5F},
    {"ccd fast", Detection::ccd, Accuracy::fast},
    {"ccd precise", Detection::ccd, Accuracy::precise},
    {"ccd conservative", Detection::ccd, Accuracy::conservative},
};

void add(Fnv1a& hash, Span<const Contact> contacts) {
  static_assert(sizeof(Contact) == 18 * 4, "padding would be part of the hash");
  hash.add_bytes(contacts.data(), contacts.size() * sizeof(Contact));
}

using Floats = std::vector<Vec3f>;

Floats floats_of(const Positions3& x) {
  Floats result;
  for (const Vec3d& p : x) result.push_back({float(p.x), float(p.y), float(p.z)});
  return result;
}

bool are_floats(const Positions3& x) {
  const Floats rounded = floats_of(x);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<double>(rounded[i][axis]);
      if (value != x[i][axis] && x[i][axis] == x[i][axis]) return false;
    }
  }
  return true;
}

bool are_floats(const Scene& scene) {
  for (const SceneBody& body : scene) {
    if (!are_floats(body.x_t0) || !are_floats(body.x_t1)) return false;
  }
  return true;
}

std::ostream& operator<<(std::ostream& out, const Golden& golden) {
  return out << golden.scene.name;
}

enum class Given { as_doubles, as_floats };

std::vector<Contact> contacts_of(const Scene& scene, const PipelineOptions& options, Given given) {
  LoadedScene loaded = load(scene, options);
  std::vector<Floats> floats;
  if (given == Given::as_floats) {
    for (const SceneBody& body : scene) {
      floats.push_back(floats_of(body.x_t0));
      floats.push_back(floats_of(body.x_t1));
    }
    for (std::size_t i = 0; i < scene.size(); ++i) {
      loaded.pipeline.scene.set_positions(loaded.ids[i], floats[2 * i], floats[2 * i + 1]);
    }
  }
  const Span<const Contact> contacts = loaded.pipeline.detect();
  return {contacts.begin(), contacts.end()};
}

void expect_golden(const Golden& golden, std::uint32_t max_threads = 0, Given given = Given::as_doubles,
                   float cell_size_factor = 0.0F) {
  const Scene scene = golden.scene.make();
  Fnv1a hash;
  std::ostringstream ways;
  for (const Way& way : kWays) {
    PipelineOptions options = test_options(way.detection);
    options.accuracy = way.accuracy;
    options.contact_rule = way.rule;
    options.motion_margin = way.motion_margin;
    options.max_threads = max_threads;
    options.cell_size_factor = cell_size_factor;
    const std::vector<Contact> contacts = contacts_of(scene, options, given);
    EXPECT_FALSE(contacts.empty()) << way.name;
    add(hash, contacts);
    ways << "\n  " << way.name << ": " << std::dec << contacts.size() << " contacts, up to here 0x" << std::hex
         << hash.value();
  }
  EXPECT_EQ(hash.value(), golden.hash) << "0x" << std::hex << hash.value() << ways.str();
}

class GoldenContacts : public testing::TestWithParam<Golden> {};

TEST_P(GoldenContacts, are_the_same) {
  expect_golden(GetParam());
}

TEST_P(GoldenContacts, from_floats) {
  if (!are_floats(GetParam().scene.make())) GTEST_SKIP() << "positions that are no floats";
  expect_golden(GetParam(), 0, Given::as_floats);
}

TEST_P(GoldenContacts, in_smaller_cells) {
  expect_golden(GetParam(), 0, Given::as_doubles, 0.6F);
}

TEST_P(GoldenContacts, on_1_to_16_threads) {
  const parallel::ThreadLimit limit(16);
  for (const std::uint32_t threads : {1U, 2U, 5U, 16U}) {
    SCOPED_TRACE(threads);
    expect_golden(GetParam(), threads);
  }
}

TEST_P(GoldenContacts, with_all_kinds_of_registers) {
  for_each_target([] { expect_golden(GetParam()); });
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenContacts, testing::ValuesIn(kGolden),
                         [](const auto& test) { return std::string(test.param.scene.name); });

}  // namespace
}  // namespace softcd::test
