#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "mesh_tools/mesh_io.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {

class MeshReading : public testing::Test {
 protected:
  mesh_tools::Mesh read(const std::string& name, const std::string& content) const {
    return mesh_tools::read_mesh(folder_.write(name, content));
  }

  /// Returns the message of the expected error; it must start with the file's name.
  std::string error_of(const std::string& name, const std::string& content) const {
    const std::string file = folder_.write(name, content);
    try {
      mesh_tools::read_mesh(file);
    } catch (const mesh_tools::MeshError& error) {
      std::string message = error.what();
      EXPECT_THAT(message, testing::StartsWith(file + ":"));
      EXPECT_THAT(message, testing::Not(testing::HasSubstr("\n")));
      return message;
    }
    ADD_FAILURE() << "this was read without an error:\n" << content;
    return "";
  }

  static std::vector<std::array<std::uint32_t, 3>> triangles_of(const mesh_tools::Mesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const Triangle& t : mesh.triangles) triangles.push_back({t.v[0], t.v[1], t.v[2]});
    return triangles;
  }

  TemporaryFolder folder_;
};

}  // namespace softcd::test
