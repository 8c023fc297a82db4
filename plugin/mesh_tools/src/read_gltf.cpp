#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>
#include <utility>

#include "parsing.hpp"

// glTF 2.0 (ISO/IEC 12113). As for the other formats the reader is softcd's own. It applies nodes in double, joins only
// equal positions, refuses what it would misplace, and no program depends on a further library.
namespace softcd::mesh_tools {
namespace {

using nlohmann::json;

/// The rows of an affine map, in double.
using Transform = std::array<std::array<double, 4>, 3>;

constexpr Transform kIdentity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

Transform operator*(const Transform& a, const Transform& b) {
  Transform product{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      product[row][column] = column == 3 ? a[row][3] : 0;
      for (std::size_t k = 0; k < 3; ++k) product[row][column] += a[row][k] * b[k][column];
    }
  }
  return product;
}

double determinant(const Transform& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Returns the map that a node's matrix, or its scale, rotation and translation describe.
Transform transform_of(const json& node) {
  Transform m{};
  if (node.contains("matrix")) {
    const auto columns = node["matrix"].get<std::array<double, 16>>();
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 4; ++column) m[row][column] = columns[4 * column + row];
    }
    return m;
  }
  const auto s = node.value("scale", std::array<double, 3>{1, 1, 1});
  const auto t = node.value("translation", std::array<double, 3>{0, 0, 0});
  const auto [x, y, z, w] = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
  m = {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0},
        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0},
        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0}}};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) m[row][column] *= s[column];
    m[row][3] = t[row];
  }
  return m;
}

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

/// The elements of an accessor, each in its bytes.
struct Elements {
  std::string_view bytes;
  std::uint64_t stride = 0, size = 0, count = 0;

  std::string_view operator[](std::uint64_t i) const { return bytes.substr(i * stride, size); }
};

class GltfReader {
 public:
  GltfReader(const std::string& file, std::string_view content) : file_(file), content_(content) {}

  Mesh read() {
    try {
      gltf_ = json::parse(split_chunks());
      require_readable();
      read_scene();
    } catch (const json::exception& error) {
      fail(fmt::format("is no valid glTF: {}", error.what()));
    }
    join_equal_positions();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw MeshError(fmt::format("{}: {}", file_, problem)); }
  void require(bool condition, const char* problem) const {
    if (!condition) fail(problem);
  }

  /// Returns the description; also finds the buffer of a .glb file.
  std::string_view split_chunks() {
    if (!content_.starts_with("glTF")) return content_;
    require(content_.size() >= 20 && little_endian(content_.substr(4, 4)) == 2, "is not glTF 2.0");
    require(little_endian(content_.substr(8, 4)) <= content_.size(), "ends too early");
    const std::uint64_t size = little_endian(content_.substr(12, 4));
    require(content_.substr(16, 4) == "JSON", "its first chunk is not JSON");
    require(size <= content_.size() - 20, "ends too early");
    if (const std::string_view rest = content_.substr(20 + size); rest.size() >= 8) {
      const std::uint64_t buffer_size = little_endian(rest.substr(0, 4));
      require(buffer_size <= rest.size() - 8, "ends too early");
      if (rest.substr(4, 3) == "BIN") buffer_ = rest.substr(8, buffer_size);
    }
    return content_.substr(20, size);
  }

  /// Refuses what would move vertices elsewhere than read() places them.
  void require_readable() const {
    require(gltf_.at("asset").at("version").get<std::string>().starts_with("2."), "is not glTF 2.0");
    for (const json& name : gltf_.value("extensionsRequired", json::array())) {
      const auto extension = name.get<std::string>();
      if (!extension.starts_with("KHR_materials_") && extension != "KHR_texture_transform")
        fail(fmt::format("needs the glTF extension {}, which is not read", in_quotes(extension)));
    }
    require(gltf_.value("animations", json::array()).empty(), "is animated; write each frame as a file of its own");
  }

  /// Returns a count, an index or an offset.
  std::uint64_t number(const json& value) const {
    require(value.is_number_unsigned() && value.get<std::uint64_t>() <= content_.size() + kMaxVertexCount,
            "has an index, count or offset that is none");
    return value.get<std::uint64_t>();
  }
  std::uint64_t number_or(const json& object, const char* key, std::uint64_t otherwise) const {
    return object.contains(key) ? number(object[key]) : otherwise;
  }
  const json& item(const char* list, const json& index) const { return gltf_.at(list).at(number(index)); }

  /// Returns an accessor's elements of the given size in bytes, which lie within the buffer.
  Elements elements(const json& accessor, std::uint64_t size) const {
    require(!accessor.contains("sparse") && accessor.contains("bufferView"),
            "has sparse accessors, which are not read");
    const json& view = item("bufferViews", accessor["bufferView"]);
    require(number(view.at("buffer")) == 0 && !gltf_.at("buffers").at(0).contains("uri") && buffer_.data() != nullptr,
            "has its vertices in another file or as text; write one .glb file");
    const std::uint64_t begin = number_or(view, "byteOffset", 0);
    const std::uint64_t view_size = number(view.at("byteLength"));
    require(begin + view_size <= buffer_.size(), "has a buffer view beyond its buffer");
    const std::uint64_t offset = number_or(accessor, "byteOffset", 0);
    const Elements found = {
        buffer_.substr(begin + std::min(offset, view_size), view_size - std::min(offset, view_size)),
        number_or(view, "byteStride", size), size, number(accessor.at("count"))};
    require(found.stride >= size && found.stride <= 252, "has a buffer view with an impossible stride");
    require(found.count == 0 || (found.count - 1) * found.stride + size <= found.bytes.size(),
            "has an accessor beyond its buffer view");
    return found;
  }

  void read_scene() {
    std::vector<bool> visited(gltf_.at("nodes").size());
    std::vector<std::pair<std::uint64_t, Transform>> pending;
    const auto push = [&](const json& nodes, const Transform& transform) {
      for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) pending.emplace_back(number(*node), transform);
    };
    const json first = 0U;
    const json& scene = item("scenes", gltf_.contains("scene") ? gltf_["scene"] : first);
    push(scene.value("nodes", json::array()), kIdentity);
    while (!pending.empty()) {
      const auto [index, parent] = pending.back();
      pending.pop_back();
      const json& node = gltf_["nodes"].at(index);
      require(!visited[index], "has a node with two parents");
      visited[index] = true;
      require(!node.contains("skin"), "is moved by a skeleton; write its vertices where they are");
      const Transform transform = parent * transform_of(node);
      if (node.contains("mesh")) {
        for (const json& primitive : item("meshes", node["mesh"]).at("primitives")) append(primitive, transform);
      }
      push(node.value("children", json::array()), transform);
    }
  }

  void append(const json& primitive, const Transform& transform) {
    constexpr std::uint64_t kTriangles = 4, kFloat = 5126;
    const std::uint64_t mode = number_or(primitive, "mode", kTriangles);
    if (mode < kTriangles) return;  // points and lines
    require(mode == kTriangles, "has triangle strips or fans; write triangles");
    require(!primitive.contains("targets"), "has morph targets; write its vertices where they are");
    const json& accessor = item("accessors", primitive.at("attributes").at("POSITION"));
    require(accessor.at("type") == "VEC3" && number(accessor.at("componentType")) == kFloat,
            "has positions that are not three floats");
    const Elements positions = elements(accessor, 12);
    const std::uint64_t first = mesh_.positions.size();
    require(first + positions.count <= kMaxVertexCount, "has too many vertices");
    for (std::uint64_t i = 0; i < positions.count; ++i) append_position(positions[i], transform);
    append_triangles(primitive, positions.count, first, determinant(transform) < 0);
  }

  void append_position(std::string_view bytes, const Transform& transform) {
    std::array<double, 3> x{};
    std::array<double, 3> moved{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      x[axis] = std::bit_cast<float>(little_endian(bytes.substr(4 * axis, 4)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::array<double, 4>& row = transform[axis];
      moved[axis] = row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3];
      if (!std::isfinite(moved[axis])) fail(fmt::format("vertex {} is not finite", mesh_.positions.size()));
    }
    mesh_.positions.push_back({moved[0], moved[1], moved[2]});
  }

  void append_triangles(const json& primitive, std::uint64_t vertex_count, std::uint64_t first, bool mirrored) {
    Elements indices{{}, 0, 0, vertex_count};
    if (primitive.contains("indices")) {
      const json& accessor = item("accessors", primitive["indices"]);
      const std::uint64_t type = number(accessor.at("componentType"));
      require(accessor.at("type") == "SCALAR" && (type == 5121 || type == 5123 || type == 5125),
              "has vertex indices that are not unsigned integers");
      indices = elements(accessor, type == 5121 ? 1 : type == 5123 ? 2 : 4);
    }
    require(indices.count % 3 == 0, "has a number of corners that is no multiple of three");
    for (std::uint64_t i = 0; i < indices.count; i += 3) {
      Triangle triangle{};
      for (std::uint64_t corner = 0; corner < 3; ++corner) {
        const std::uint64_t index = indices.size == 0 ? i + corner : little_endian(indices[i + corner]);
        if (index >= vertex_count)
          fail(fmt::format("vertex index {} does not exist ({} vertices)", index, vertex_count));
        triangle.v[corner] = static_cast<std::uint32_t>(first + index);
      }
      if (mirrored) std::swap(triangle.v[1], triangle.v[2]);
      mesh_.triangles.push_back(triangle);
    }
  }

  /// Joins the vertices that the format stores once for each normal, colour or texture coordinate. Each joined vertex
  /// takes the place of its first.
  void join_equal_positions() {
    const std::vector<Vec3d> positions = std::exchange(mesh_.positions, {});
    const auto key = [&](std::uint32_t i) { return std::tie(positions[i].x, positions[i].y, positions[i].z); };
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    std::vector<std::uint32_t> joined(positions.size());  // first the first equal vertex, then its new index
    for (std::size_t i = 0; i < order.size(); ++i) {
      const bool is_first = i == 0 || key(order[i - 1]) != key(order[i]);
      joined[order[i]] = is_first ? order[i] : joined[order[i - 1]];
    }
    for (std::uint32_t i = 0; i < joined.size(); ++i) {
      if (joined[i] == i) {
        joined[i] = static_cast<std::uint32_t>(mesh_.positions.size());
        mesh_.positions.push_back(positions[i]);
      } else {
        joined[i] = joined[joined[i]];
      }
    }
    for (Triangle& triangle : mesh_.triangles) {
      for (std::uint32_t& vertex : triangle.v) vertex = joined[vertex];
    }
  }

  const std::string& file_;
  std::string_view content_;
  std::string_view buffer_;
  json gltf_;
  Mesh mesh_;
};

}  // namespace

Mesh read_gltf(const std::string& file, std::string_view content) {
  return GltfReader(file, content).read();
}

}  // namespace softcd::mesh_tools
