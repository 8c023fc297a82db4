#include <gmock/gmock.h>

#include <functional>

#include "backend_under_test.hpp"
#include "rank_scene.hpp"
#include "softcd/fields/options.hpp"

namespace softcd::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Small {
  bool a = false;
  float b = 0;
};

static_assert(takes_members<Small>(AnyMember(), AnyMember()));
static_assert(!takes_members<Small>(AnyMember(), AnyMember(), AnyMember()));

/// Gives a field another value of its range.
template <class Field, class Struct>
void change(const Field& field, Struct& object) {
  auto& value = field.of(object);
  using Value = std::remove_cvref_t<decltype(value)>;
  if constexpr (std::is_same_v<Value, Communicator>) {
    value = Communicator::of_threads(1).front();
  } else if constexpr (std::is_pointer_v<Value>) {
    value = &object;
  } else if constexpr (std::is_enum_v<Value>) {
    value = Value{value == Value{} ? 1U : 0U};
  } else if constexpr (std::is_same_v<Value, bool>) {
    value = !value;
  } else {
    value += 1;
  }
  EXPECT_EQ(problem_of(object), "");
}

template <class Struct>
void expect_that_each_field_counts() {
  for_each_field<Struct>([](auto field) {
    SCOPED_TRACE(field.kName);
    Struct changed;
    change(field, changed);
    EXPECT_FALSE(changed == Struct());
    EXPECT_TRUE(changed != Struct());
    EXPECT_TRUE(changed == Struct(changed));
  });
}

TEST(Options, are_equal_where_all_fields_are) {
  expect_that_each_field_counts<SceneOptions>();
  expect_that_each_field_counts<QueryOptions>();
  expect_that_each_field_counts<ProbeOptions>();
  for_each_field<BodySettings>([](auto field) {
    BodySettings changed;
    change(field, changed);
    EXPECT_FALSE(has_equal_fields(changed, BodySettings())) << field.kName;
  });
}

TEST(Options, have_the_names_of_members_and_enumerators) {
  std::vector<std::string> names(kEnumerators<Accuracy>.begin(), kEnumerators<Accuracy>.end());
  EXPECT_THAT(names, ElementsAre("fast", "precise", "conservative", "automatic"));
  names.clear();
  for_each_field<BodySettings>([&](auto field) { names.emplace_back(field.kName); });
  EXPECT_THAT(names, ElementsAre("margin", "filter_group", "filter_mask", "self_collision", "kinematic",
                                 "vertex_triangle", "edge_edge", "batch", "neighbour_rings", "rest_distance"));
}

TEST(Options, have_their_names_from_signatures_of_all_compilers) {
  EXPECT_EQ(last_name("constexpr auto name_in_source() [with auto kConstant = &softcd::QueryOptions::detection]"),
            "detection");
  EXPECT_EQ(last_name("auto name_in_source() [kConstant = softcd::Accuracy::precise]"), "precise");
  EXPECT_EQ(last_name("auto name_in_source() [kConstant = (softcd::Accuracy)7]"), "7");
  EXPECT_EQ(last_name("auto __cdecl name_in_source<&kNoObject<struct softcd::QueryOptions>->edge_edge>(void)"),
            "edge_edge");
  EXPECT_EQ(last_name("auto __cdecl name_in_source<softcd::Accuracy::fast>(void)"), "fast");
  EXPECT_EQ(last_name("auto __cdecl name_in_source<(enum softcd::Accuracy)0x7>(void)"), "0x7");
}

TEST(Options, are_refused_by_name_value_and_range) {
  QueryOptions options;
  EXPECT_EQ(problem_of(options), "");
  options.cell_size_factor = 0.05F;
  EXPECT_EQ(problem_of(options), "cell_size_factor is 0.05, but must be 0, or 0.1 to 100");
  options.cell_size_factor = 0.1F;
  options.motion_margin = -1.0F;
  EXPECT_EQ(problem_of(options), "motion_margin is -1, but must be finite and at least 0");
  options.contact_rule = ContactRule{7};
  options.motion_margin = 0;
  EXPECT_EQ(problem_of(options), "contact_rule is 7, which is none of its values; they count from 0 to 2");
  SceneOptions scene_options;
  scene_options.cuda_device = -2;
  EXPECT_EQ(problem_of(scene_options), "cuda_device is -2, but must be at least -1");
}

/// Returns the errors of two ranks in a detection for which one of them has other settings and options.
std::string problem_of_ranks(const std::function<void(Scene&, PipelineOptions&)>& change_one) {
  const std::vector<std::string> problems = in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
    const Mesh triangle = {{{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    Scene scene = {still(triangle, BodySettings())};
    PipelineOptions options = test_options(Detection::dcd);
    if (rank.rank() == 1) change_one(scene, options);
    RankScene part(scene, rank, options);
    part.set_positions(scene);
    part.query().detect();
  });
  EXPECT_EQ(problems[0], problems[1]);
  return problems[0];
}

TEST(Options, of_ranks_are_compared) {
  for_each_field<BodySettings>([](auto field) {
    const std::string problem =
        problem_of_ranks([&](Scene& scene, PipelineOptions&) { change(field, scene.front().settings); });
    EXPECT_THAT(problem, HasSubstr("the ranks have different scenes")) << field.kName;
  });
  for_each_field<QueryOptions>([](auto field) {
    if (field.kMayDiffer) return;
    const std::string problem =
        problem_of_ranks([&](Scene&, PipelineOptions& options) { change(field, static_cast<QueryOptions&>(options)); });
    EXPECT_THAT(problem, HasSubstr("the ranks start different detections")) << field.kName;
  });
}

TEST(Options, of_ranks_that_change_no_contacts_may_differ) {
  EXPECT_EQ(problem_of_ranks([](Scene&, PipelineOptions& options) { options.reuse_pairs = false; }), "");
  std::vector<std::string> names;
  for_each_field<QueryOptions>([&](auto field) {
    if (field.kMayDiffer) names.emplace_back(field.kName);
  });
  EXPECT_THAT(names, ElementsAre("reuse_pairs", "contacts_on_device"));
}

}  // namespace
}  // namespace softcd::test
