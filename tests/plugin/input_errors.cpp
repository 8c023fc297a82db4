#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "softcd/fields/options.hpp"

namespace softcd::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr float kFloatNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

template <class Exception, class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const Exception& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return {};
  }
  ADD_FAILURE() << "no exception";
  return {};
}

/// Two bodies in contact. Whatever error a test causes, they must have the same contact afterwards.
class InputErrors : public testing::Test {
 protected:
  InputErrors()
      : loaded_(load({still(grid_cloth(6, 6, 0.25), everything(0.05F)),
                      still(moved(grid_cloth(6, 6, 0.25), {0.1, 0.1, 0.06}), everything(0.05F))},
                     test_options(Detection::dcd))) {
    const Span<const Contact> contacts = loaded_.pipeline.detect();
    expected_.assign(contacts.begin(), contacts.end());
  }

  void TearDown() override {
    EXPECT_FALSE(expected_.empty());
    EXPECT_TRUE(identical(expected_, loaded_.pipeline.detect())) << "the pipeline changed";
    EXPECT_EQ(loaded_.pipeline.query.statistics().bodies, 2U);
  }

  CollisionPipeline& pipeline() { return loaded_.pipeline; }
  BodyId body(std::size_t place) const { return loaded_.ids[place]; }
  static std::string name_of(BodyId id) { return std::to_string(id.value); }

  LoadedScene loaded_;
  std::vector<Contact> expected_;
};

TEST_F(InputErrors, index_out_of_range) {
  const std::vector<Triangle> triangles{{{0, 1, 2}}, {{2, 1, 3}}, {{1, 2, 44}}};
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.add_body({triangles, 4, {}});
              }),
              AllOf(HasSubstr("triangle 2"), HasSubstr("44")));
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.update_body(body(1), {triangles, 4, {}});
              }),
              AllOf(HasSubstr("triangle 2"), HasSubstr("44"), HasSubstr("body " + name_of(body(1)))));
}

TEST_F(InputErrors, index_just_out_of_range) {
  const std::vector<Triangle> triangles{{{0, 1, 4}}};
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.add_body({triangles, 4, {}});
              }),
              HasSubstr("triangle 0"));
}

TEST_F(InputErrors, negative_index_as_unsigned) {
  const std::vector<Triangle> triangles{{{0, static_cast<std::uint32_t>(-1), 2}}};
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.add_body({triangles, 4, {}});
              }),
              AllOf(HasSubstr("triangle 0"), HasSubstr("4294967295")));
}

TEST_F(InputErrors, index_without_vertices) {
  const std::vector<Triangle> triangles{{{0, 0, 0}}};
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.add_body({triangles, 0, {}});
              }),
              HasSubstr("triangle 0"));
}

TEST_F(InputErrors, position_count) {
  const Positions3 right(36);
  for (const std::size_t wrong_count : {0U, 35U, 37U}) {
    const Positions3 wrong(wrong_count);
    const auto names_counts =
        AllOf(HasSubstr("body " + name_of(body(1))), HasSubstr(std::to_string(wrong_count)), HasSubstr("36"));
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(body(1), wrong); }), names_counts);
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(body(1), right, wrong); }), names_counts);
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(body(1), wrong, right); }), names_counts);
  }
}

TEST_F(InputErrors, null_positions) {
  EXPECT_THAT(message_of<InvalidInput>([&] {
                pipeline().scene.set_positions(body(0),
                                               Positions(static_cast<const float*>(nullptr), 36, sizeof(Vec3f)));
              }),
              HasSubstr("body " + name_of(body(0))));
}

TEST_F(InputErrors, ends_of_the_step_in_different_types) {
  const Positions3 doubles(36);
  const std::vector<Vec3f> floats(36);
  EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(body(0), doubles, floats); }),
              HasSubstr("body " + name_of(body(0))));
}

TEST_F(InputErrors, stride_shorter_than_a_position) {
  const std::vector<float> numbers(200);
  EXPECT_THAT(message_of<InvalidInput>(
                  [&] { pipeline().scene.set_positions(body(0), Positions(numbers.data(), 36, 2 * sizeof(float))); }),
              AllOf(HasSubstr("body " + name_of(body(0))), HasSubstr("stride")));
}

TEST_F(InputErrors, misaligned_positions) {
  alignas(8) std::byte memory[1024] = {};
  const auto* const floats = reinterpret_cast<const float*>(memory);
  const auto* const doubles = reinterpret_cast<const double*>(memory);
  const auto names_body = AllOf(HasSubstr("body " + name_of(body(0))), HasSubstr("multiples"));
  for (const Positions& wrong : {Positions(floats, 36, 13), Positions(doubles, 36, 28),
                                 Positions(reinterpret_cast<const float*>(memory + 2), 36, 16),
                                 Positions(reinterpret_cast<const double*>(memory + 4), 36, 24)}) {
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(body(0), wrong); }), names_body);
  }
}

TEST_F(InputErrors, unknown_body) {
  const Positions3 x(36);
  const std::vector<Triangle> triangles{{{0, 1, 2}}};
  for (const BodyId unknown : {BodyId{}, BodyId{2}, BodyId{77}}) {
    const auto names_body = HasSubstr("body " + name_of(unknown));
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(unknown, x); }), names_body);
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_settings(unknown, {}); }), names_body);
    EXPECT_THAT(message_of<InvalidInput>([&] {
                  pipeline().scene.update_body(unknown, {triangles, 3, {}});
                }),
                names_body);
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.remove_body(unknown); }), names_body);
  }
}

TEST_F(InputErrors, removed_body) {
  const std::vector<Triangle> triangles{{{0, 1, 2}}};
  const BodyId removed = pipeline().scene.add_body({triangles, 3, {}});
  pipeline().scene.remove_body(removed);
  const Positions3 x(3);
  const auto names_body = HasSubstr("body " + name_of(removed));
  EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_positions(removed, x); }), names_body);
  EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.remove_body(removed); }), names_body);
}

TEST_F(InputErrors, margin) {
  const std::vector<Triangle> triangles{{{0, 1, 2}}};
  for (const float wrong : {kFloatNaN, kFloatInfinity, -kFloatInfinity, -1e-30F, -1.0F}) {
    BodySettings settings;
    settings.margin = wrong;
    EXPECT_THAT(message_of<InvalidInput>([&] {
                  pipeline().scene.add_body({triangles, 3, settings});
                }),
                HasSubstr("margin"));
    EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().scene.set_settings(body(1), settings); }),
                AllOf(HasSubstr("margin"), HasSubstr("body " + name_of(body(1)))));
    EXPECT_THAT(message_of<InvalidInput>([&] {
                  pipeline().scene.update_body(body(1), {triangles, 3, settings});
                }),
                AllOf(HasSubstr("margin"), HasSubstr("body " + name_of(body(1)))));
  }
}

TEST_F(InputErrors, values_that_no_option_has) {
  const auto expect_refused = [&](auto field) {
    using Value = typename decltype(field)::Value;
    const auto expect_one_refused = [&](Value wrong) {
      PipelineOptions options = test_options(Detection::dcd);
      field.of(options) = wrong;
      const auto is_named = HasSubstr(std::string(field.kName) + " is ");
      EXPECT_THAT(message_of<InvalidInput>([&] { CollisionPipeline unusable(options); }), is_named);
      EXPECT_THAT(message_of<InvalidInput>([&] { pipeline().set_options(options); }), is_named);
    };
    if constexpr (std::is_enum_v<Value>) expect_one_refused(Value{77});
    if constexpr (std::is_same_v<Value, float>) {
      for (const float wrong : {kFloatNaN, kFloatInfinity, -1.0F}) expect_one_refused(wrong);
    }
  };
  for_each_field<SceneOptions>(expect_refused);
  for_each_field<QueryOptions>(expect_refused);
}

TEST_F(InputErrors, every_error_is_an_error) {
  EXPECT_THROW(pipeline().scene.remove_body({}), Error);
  EXPECT_THROW(pipeline().scene.remove_body({}), std::runtime_error);
}

// A filter that throws ends the detection. The positions of that detection are kept, though their memory may be gone.
TEST_F(InputErrors, exception_in_the_pair_filter) {
  auto frame = std::make_unique<Positions3>(loaded_.scene[1].x_t1);
  pipeline().scene.set_positions(body(1), *frame);
  pipeline().query.set_pair_filter([](BodyId, BodyId) -> bool { throw std::domain_error("from the filter"); });
  EXPECT_EQ(message_of<std::domain_error>([&] { pipeline().detect(); }), "from the filter");
  frame.reset();
  // Exceptions of types that softcd also throws still belong to the caller.
  pipeline().query.set_pair_filter([](BodyId, BodyId) -> bool { throw std::bad_alloc(); });
  EXPECT_THROW(static_cast<void>(pipeline().query.start()), std::bad_alloc);
  pipeline().query.set_pair_filter({});
}

TEST_F(InputErrors, exception_in_the_log) {
  const float strays[3] = {kFloatNaN, 0.0F, 0.0F};
  const std::vector<Triangle> triangles{{{0, 0, 0}}};
  const BodyId spoilt = pipeline().scene.add_body({triangles, 1, {}});
  pipeline().scene.set_positions(spoilt, Positions(strays, 1, sizeof(strays)));
  pipeline().scene.set_log([](LogLevel, std::string_view) { throw std::domain_error("from the log"); });
  EXPECT_EQ(message_of<std::domain_error>([&] { pipeline().detect(); }), "from the log");
  EXPECT_TRUE(identical(expected_, pipeline().detect())) << "said once";
  pipeline().scene.remove_body(spoilt);
}

}  // namespace
}  // namespace softcd::test
