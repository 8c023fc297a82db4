// A certificate has the same bytes from every compiler and on every machine.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "certifier.hpp"
#include "mesh_sequence.hpp"
#include "sha256.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

constexpr int kVerticesOfSide = 12;

std::string wavy_sheet(int frame, bool is_moving) {
  std::string text;
  for (int i = 0; i < kVerticesOfSide * kVerticesOfSide; ++i) {
    const double wave = 0.01 * (i * i % 11) + 0.003 * (i * frame % 5);
    const double height = is_moving ? 0.35 - 0.1 * frame + wave : -wave;
    text +=
        fmt::format("v {} {} {}\n", 0.1 * (i % kVerticesOfSide) + 0.013 * frame, 0.1 * (i / kVerticesOfSide), height);
  }
  return text;
}

std::string triangles_of_wave(int first) {
  std::string text;
  for (int row = 0; row + 1 < kVerticesOfSide; ++row) {
    for (int column = 0; column + 1 < kVerticesOfSide; ++column) {
      const int v = first + row * kVerticesOfSide + column + 1;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", v, v + 1, v + kVerticesOfSide, v + 1, v + kVerticesOfSide + 1,
                          v + kVerticesOfSide);
    }
  }
  return text;
}

TEST(CertificateBytes, are_the_same_everywhere) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (int frame = 0; frame < 6; ++frame) {
    files.emplace_back(folder.write(fmt::format("frame{}.obj", frame),
                                    wavy_sheet(frame, false) + wavy_sheet(frame, true) + triangles_of_wave(0) +
                                        triangles_of_wave(kVerticesOfSide * kVerticesOfSide)));
  }
  const auto ignore = [](auto&&...) {};
  demo::CertifyOptions options;
  options.list = 1000;
  nlohmann::ordered_json certificate = nlohmann::ordered_json::parse(
      text_of(demo::certify(options, {.backend = Backend::cpu}, {demo::MeshSequence(files)}, ignore, ignore)));
  certificate.erase("softcd");
  EXPECT_GT(certificate.at("proved_steps"), 0);
  EXPECT_LT(certificate.at("proved_steps"), 5);
  EXPECT_EQ(demo::sha256(certificate.dump()), "dd44fcd47abe241b6baf64b58b5da6def37d499e7f5947dcbf4c1782bf1f97b3");
}

}  // namespace
}  // namespace softcd::test
