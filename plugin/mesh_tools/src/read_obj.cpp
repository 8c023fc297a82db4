#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "parsing.hpp"

namespace softcd::mesh_tools {
namespace {

// Statements of the format that say nothing about vertices and faces.
constexpr std::array<std::string_view, 34> kIgnored = {
    "vn",     "vt",     "vp",     "l",      "p",          "g",         "o",        "s",        "mg",
    "usemtl", "mtllib", "usemap", "maplib", "lod",        "bevel",     "c_interp", "d_interp", "cstype",
    "deg",    "bmat",   "step",   "parm",   "trim",       "hole",      "scrv",     "sp",       "end",
    "con",    "ctech",  "stech",  "call",   "shadow_obj", "trace_obj", "csh"};

class ObjReader {
 public:
  ObjReader(const std::string& file, std::string_view content) : file_(file), rest_(content) {}

  Mesh read() {
    while (!rest_.empty()) {
      ++line_;
      std::string_view line = take_line(rest_);
      line = line.substr(0, line.find('#'));
      if (line.find('\0') != std::string_view::npos) fail("is not text");
      read_statement(line);
    }
    require_known_vertices();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { fail(line_, problem); }
  [[noreturn]] void fail(std::size_t line, const std::string& problem) const {
    throw MeshError(fmt::format("{}:{}: {}", file_, line, problem));
  }

  void read_statement(std::string_view line) {
    const std::string_view keyword = take_word(line);
    if (keyword == "v") return read_vertex(line);
    if (keyword == "f") return read_face(line);
    if (keyword == "curv" || keyword == "curv2" || keyword == "surf") fail("free-form geometry is not read");
    if (keyword.empty() || std::find(kIgnored.begin(), kIgnored.end(), keyword) != kIgnored.end()) return;
    fail(fmt::format("unknown statement {}", in_quotes(keyword)));
  }

  // v x y z, then perhaps a weight or a colour.
  void read_vertex(std::string_view line) {
    Vec3d position;
    for (double* coordinate : {&position.x, &position.y, &position.z}) {
      const std::string_view word = take_word(line);
      if (word.empty()) fail("a vertex needs three coordinates");
      const std::optional<double> value = parse_number<double>(word);
      if (!value) fail(fmt::format("{} is not a coordinate", in_quotes(word)));
      *coordinate = *value;
    }
    if (mesh_.positions.size() == kMaxVertexCount) fail("too many vertices");
    mesh_.positions.push_back(position);
  }

  // f v/vt/vn ...: counted from 1, or from -1 backwards from the last vertex so far.
  void read_face(std::string_view line) {
    corners_.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      const std::optional<std::int64_t> number = parse_number<std::int64_t>(word.substr(0, word.find('/')));
      if (!number) fail(fmt::format("{} is not a vertex index", in_quotes(word)));
      const auto count = static_cast<std::int64_t>(mesh_.positions.size());
      const std::int64_t index = *number < 0 ? count + *number : *number - 1;
      if (index < 0) fail(fmt::format("vertex index {} does not exist ({} vertices so far)", *number, count));
      if (index >= static_cast<std::int64_t>(kMaxVertexCount))
        fail(fmt::format("vertex index {} is too large", *number));
      corners_.push_back(static_cast<std::uint32_t>(index));
    }
    if (corners_.size() < 3) fail(fmt::format("a face needs three vertices or more, not {}", corners_.size()));
    append_fan(corners_, mesh_.triangles);
    triangle_lines_.resize(mesh_.triangles.size(), line_);
  }

  // Faces may name vertices that come later in the file.
  void require_known_vertices() const {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t index : mesh_.triangles[t].v) {
        if (index < mesh_.positions.size()) continue;
        fail(triangle_lines_[t], fmt::format("vertex index {} does not exist ({} vertices)", std::uint64_t{index} + 1,
                                             mesh_.positions.size()));
      }
    }
  }

  const std::string& file_;
  std::string_view rest_;
  std::size_t line_ = 0;
  Mesh mesh_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> triangle_lines_;
};

}  // namespace

Mesh read_obj(const std::string& file, std::string_view content) {
  return ObjReader(file, content).read();
}

}  // namespace softcd::mesh_tools
