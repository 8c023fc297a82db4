#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;

struct Asked {
  int questions = 0;
  std::map<std::string, std::size_t> answers;  ///< by the answering library
};

/// Returns the questions about bodies, shapes and changes, by kind.
std::map<std::string, Asked> asked_about_bodies(const nlohmann::json& rows) {
  std::map<std::string, Asked> asked;
  for (const auto& row : rows) {
    EXPECT_GT(row.at("us_each"), 0) << row;
    EXPECT_GT(row.at("answers"), 0) << row;
    Asked& question = asked[row.at("question")];
    if (row.at("name") == "softcd, cpu") question.questions = row.at("questions");
    question.answers[row.at("name")] = row.at("answers");
  }
  return asked;
}

class BenchQueries : public testing::Test {
 protected:
  Result run(const std::string& arguments) const { return run_program(SOFTCD_BENCH, "queries " + arguments, folder_); }

  TemporaryFolder folder_;
};

// Other libraries answer the same questions: the program fails where their results differ.
TEST_F(BenchQueries, all_questions_are_measured) {
  const Result result =
      run("--questions 1000 --repeat 1 --json " + folder_.file("json") + " --markdown " + folder_.file("table.md"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, folder_.read("table.md"));
  EXPECT_THAT(result.output, HasSubstr("1000 rays"));
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  ASSERT_FALSE(json.at("rows").empty());
  EXPECT_EQ(json["rows"][0]["name"], "softcd, cpu");
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["triangles"], 90000) << row;
    EXPECT_EQ(row["rays"], 1000) << row;
    EXPECT_GT(row["ms"]["build"], 0) << row;
    EXPECT_GT(row["ms"]["rays"], 0) << row;
  }
  const std::map<std::string, int> questions = {{"distance of two bodies", 2},
                                                {"intersections of two", 2},
                                                {"whether two intersect", 2},
                                                {"intersections within the mesh", 1},
                                                {"capsules", 10},
                                                {"hulls", 10},
                                                {"changes", 10}};
  std::map<std::string, Asked> asked = asked_about_bodies(json.at("bodies"));
  EXPECT_EQ(asked.size(), questions.size());
  for (const auto& [question, count] : questions) EXPECT_EQ(asked[question].questions, count) << question;
  for (const char* question : {"distance of two bodies", "intersections of two", "changes"}) {
    EXPECT_EQ(asked[question].answers.count("every two triangles"), 1U) << question;
  }
  for (const char* question : {"capsules", "hulls"}) {
    const std::map<std::string, std::size_t>& answers = asked[question].answers;
    if (answers.count("Bullet") == 0) continue;  // built without it
    const auto expected = static_cast<double>(answers.at("softcd, cpu"));
    EXPECT_NEAR(static_cast<double>(answers.at("Bullet")), expected, 0.02 * expected) << question;
  }
}

TEST_F(BenchQueries, without_rivals_softcd_alone_is_measured) {
  const Result result = run("--questions 100 --repeat 1 --no-rivals --json " + folder_.file("json"));
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const nlohmann::json json = nlohmann::json::parse(folder_.read("json"));
  EXPECT_EQ(json.at("bodies").size(), 7U);
  for (const auto& row : json["bodies"]) EXPECT_EQ(row.at("name"), "softcd, cpu") << row;
}

TEST_F(BenchQueries, a_folder_without_meshes_is_wrong_input) {
  EXPECT_EQ(run("--step " + folder_.file("missing")).exit_code, 2);
}

}  // namespace
}  // namespace softcd::test
