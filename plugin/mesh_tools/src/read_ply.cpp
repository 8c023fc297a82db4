#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <unordered_set>

#include "parsing.hpp"

namespace softcd::mesh_tools {
namespace {

enum class Format { ascii, little_endian, big_endian };

struct ScalarType {
  std::string_view name, other_name;
  std::size_t size;
  bool is_integer;
  double lowest, highest;  ///< of integers
  double (*from_bytes)(const char* bytes, bool swap);
};

template <class T>
double number_from_bytes(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> own;
  std::copy_n(bytes, sizeof(T), own.begin());
  if (swap) std::reverse(own.begin(), own.end());
  return static_cast<double>(std::bit_cast<T>(own));
}

template <class T>
constexpr ScalarType make_scalar_type(std::string_view name, std::string_view other_name) {
  using Limits = std::numeric_limits<T>;
  return {name,
          other_name,
          sizeof(T),
          Limits::is_integer,
          static_cast<double>(Limits::lowest()),
          static_cast<double>(Limits::max()),
          number_from_bytes<T>};
}

// All of them fit into double without loss.
constexpr std::array<ScalarType, 8> kScalarTypes = {
    make_scalar_type<std::int8_t>("char", "int8"),    make_scalar_type<std::uint8_t>("uchar", "uint8"),
    make_scalar_type<std::int16_t>("short", "int16"), make_scalar_type<std::uint16_t>("ushort", "uint16"),
    make_scalar_type<std::int32_t>("int", "int32"),   make_scalar_type<std::uint32_t>("uint", "uint32"),
    make_scalar_type<float>("float", "float32"),      make_scalar_type<double>("double", "float64")};

struct Property {
  std::string name;
  const ScalarType* type = nullptr;        ///< of the value or of the list's items
  const ScalarType* count_type = nullptr;  ///< of a list's length; null: not a list
};

template <class Named>
const Named* find_in(const std::vector<Named>& all, std::string_view name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  const Property* find(std::string_view property) const { return find_in(properties, property); }
};

struct Header {
  Format format = Format::ascii;
  std::vector<Element> elements;
  std::size_t lines = 0;

  const Element* find(std::string_view element) const { return find_in(elements, element); }
};

class HeaderReader {
 public:
  HeaderReader(const std::string& file, std::string_view& rest) : file_(file), rest_(rest) {}

  // Reads the header. Leaves `rest` at the first byte after it.
  Header read() {
    bool has_format = false;
    while (true) {
      if (rest_.empty()) fail("the header has no end_header");
      ++header_.lines;
      std::string_view line = take_line(rest_);
      const std::string_view keyword = take_word(line);
      if (keyword == "end_header") break;
      if (keyword == "format") {
        has_format = true;
        header_.format = read_format(line);
      } else if (keyword == "element") {
        read_element(line);
      } else if (keyword == "property") {
        read_property(line);
      } else if (keyword != "ply" && keyword != "comment" && keyword != "obj_info") {
        fail(fmt::format("unknown word {} in the header", in_quotes(keyword)));
      }
    }
    if (!has_format) fail("the header names no format");
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw MeshError(fmt::format("{}:{}: {}", file_, header_.lines, problem));
  }

  Format read_format(std::string_view line) const {
    const std::string_view name = take_word(line);
    const std::string_view version = take_word(line);
    if (version != "1.0") fail(fmt::format("unknown PLY version {}", in_quotes(version)));
    if (name == "ascii") return Format::ascii;
    if (name == "binary_little_endian") return Format::little_endian;
    if (name == "binary_big_endian") return Format::big_endian;
    fail(fmt::format("unknown format {}", in_quotes(name)));
  }

  void read_element(std::string_view line) {
    const std::string_view name = take_word(line);
    const std::string_view count = take_word(line);
    const std::optional<std::uint64_t> number = parse_number<std::uint64_t>(count);
    if (!number) fail(fmt::format("{} is not a number of elements", in_quotes(count)));
    if (!elements_.emplace(name).second) fail(fmt::format("element {} is declared twice", in_quotes(name)));
    properties_.clear();
    header_.elements.push_back({std::string(name), *number, {}});
  }

  void read_property(std::string_view line) {
    if (header_.elements.empty()) fail("a property comes before the first element");
    Element& element = header_.elements.back();
    Property property;
    std::string_view word = take_word(line);
    if (word == "list") {
      property.count_type = find_type(take_word(line));
      if (!property.count_type->is_integer) fail("the length of a list is not of an integer type");
      word = take_word(line);
    }
    property.type = find_type(word);
    property.name = std::string(take_word(line));
    if (property.name.empty()) fail("a property has no name");
    if (!properties_.insert(property.name).second) {
      fail(fmt::format("property {} is declared twice", in_quotes(property.name)));
    }
    element.properties.push_back(std::move(property));
  }

  const ScalarType* find_type(std::string_view name) const {
    for (const ScalarType& type : kScalarTypes) {
      if (name == type.name || name == type.other_name) return &type;
    }
    fail(fmt::format("unknown type {}", in_quotes(name)));
  }

  const std::string& file_;
  std::string_view& rest_;
  Header header_;
  std::unordered_set<std::string> elements_;
  std::unordered_set<std::string> properties_;  ///< of the last element
};

// Reads the values after the header, one by one.
class ValueReader {
 public:
  ValueReader(const std::string& file, std::string_view content, std::string_view rest, const Header& header)
      : file_(file), begin_(content.data()), rest_(rest), line_(header.lines + 1), format_(header.format) {}

  [[noreturn]] void fail(const std::string& problem) const {
    const std::string place = format_ == Format::ascii ? fmt::format("{}:{}", file_, line_)
                                                       : fmt::format("{}: byte {}", file_, rest_.data() - begin_);
    throw MeshError(fmt::format("{}: {}", place, problem));
  }

  double next(const ScalarType& type) { return format_ == Format::ascii ? next_word(type) : next_bytes(type); }

  // A header may announce more than memory can hold, so nothing is allocated before the file is known to be long
  // enough.
  void require_room_for(const Element& element) const {
    std::uint64_t least = 0;
    for (const Property& property : element.properties) {
      const ScalarType& first = property.count_type != nullptr ? *property.count_type : *property.type;
      least += format_ == Format::ascii ? 1 : first.size;
    }
    if (least != 0 && element.count > rest_.size() / least) {
      fail(fmt::format("the file is truncated: {} {} elements do not fit into the {} bytes left", element.count,
                       in_quotes(element.name), rest_.size()));
    }
  }

  void require_end() {
    skip_blanks();
    if (!rest_.empty()) fail(fmt::format("{} bytes follow the last element", rest_.size()));
  }

 private:
  static constexpr std::string_view kWordEnds = " \t\r\v\f\n";

  void skip_blanks() {
    while (!rest_.empty() && kWordEnds.find(rest_.front()) != std::string_view::npos) {
      if (rest_.front() == '\n') ++line_;
      rest_.remove_prefix(1);
    }
  }

  double next_word(const ScalarType& type) {
    skip_blanks();
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kWordEnds));
    if (word.empty()) fail("the file is truncated");
    rest_.remove_prefix(word.size());
    const std::optional<double> value = parse_number<double>(word);
    if (!value || (type.is_integer && !parse_number<std::int64_t>(word))) {
      fail(fmt::format("{} is not a number of type {}", in_quotes(word), type.name));
    }
    if (type.is_integer && (*value < type.lowest || *value > type.highest)) {
      fail(fmt::format("{} is out of the range of type {}", in_quotes(word), type.name));
    }
    const bool is_single = !type.is_integer && type.size == sizeof(float);
    return is_single ? static_cast<double>(static_cast<float>(*value)) : *value;
  }

  double next_bytes(const ScalarType& type) {
    if (rest_.size() < type.size) fail("the file is truncated");
    constexpr Format kNative = std::endian::native == std::endian::little ? Format::little_endian : Format::big_endian;
    const double value = type.from_bytes(rest_.data(), format_ != kNative);
    rest_.remove_prefix(type.size);
    return value;
  }

  const std::string& file_;
  const char* begin_;
  std::string_view rest_;
  std::size_t line_;
  Format format_;
};

class BodyReader {
 public:
  BodyReader(const Header& header, ValueReader& values) : header_(header), values_(values) {}

  Mesh read() {
    const Element* vertex = header_.find("vertex");
    if (vertex == nullptr) values_.fail("the header names no vertices");
    if (vertex->count > kMaxVertexCount) values_.fail(fmt::format("{} vertices are too many", vertex->count));
    if (header_.find("tristrips") != nullptr) values_.fail("triangle strips are not read");
    vertex_count_ = vertex->count;
    for (const Element& element : header_.elements) read_element(element);
    values_.require_end();
    return std::move(mesh_);
  }

 private:
  void read_element(const Element& element) {
    values_.require_room_for(element);
    if (element.name == "vertex") {
      read_vertices(element);
    } else if (element.name == "face") {
      read_faces(element);
    } else if (!element.properties.empty()) {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        for (const Property& property : element.properties) skip(property);
      }
    }
  }

  void read_vertices(const Element& element) {
    const std::array<const Property*, 3> axes = {element.find("x"), element.find("y"), element.find("z")};
    for (const Property* axis : axes) {
      if (axis == nullptr || axis->count_type != nullptr) values_.fail("vertices need the numbers x, y and z");
    }
    mesh_.positions.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Vec3d position{};
      for (const Property& property : element.properties) {
        if (property.count_type != nullptr) {
          skip(property);
          continue;
        }
        const double value = values_.next(*property.type);
        if (&property == axes[0]) position.x = value;
        if (&property == axes[1]) position.y = value;
        if (&property == axes[2]) position.z = value;
      }
      mesh_.positions.push_back(position);
    }
  }

  void read_faces(const Element& element) {
    const Property* indices = element.find("vertex_indices");
    if (indices == nullptr) indices = element.find("vertex_index");
    if (indices == nullptr || indices->count_type == nullptr || !indices->type->is_integer) {
      values_.fail("faces need a list of integers vertex_indices");
    }
    mesh_.triangles.reserve(element.count);
    for (std::uint64_t face = 0; face < element.count; ++face) {
      for (const Property& property : element.properties) {
        if (&property == indices) {
          read_corners(face, property);
        } else {
          skip(property);
        }
      }
    }
  }

  void read_corners(std::uint64_t face, const Property& property) {
    const std::uint64_t length = next_length(property);
    if (length < 3) values_.fail(fmt::format("face {} has {} vertices; it needs three or more", face, length));
    corners_.clear();
    for (std::uint64_t i = 0; i < length; ++i) {
      const double index = values_.next(*property.type);
      if (index < 0 || index >= static_cast<double>(vertex_count_)) {
        values_.fail(fmt::format("face {}: vertex index {} does not exist ({} vertices)", face, index, vertex_count_));
      }
      corners_.push_back(static_cast<std::uint32_t>(index));
    }
    append_fan(corners_, mesh_.triangles);
  }

  void skip(const Property& property) {
    const std::uint64_t count = property.count_type == nullptr ? 1 : next_length(property);
    for (std::uint64_t i = 0; i < count; ++i) values_.next(*property.type);
  }

  std::uint64_t next_length(const Property& list) {
    const double length = values_.next(*list.count_type);
    if (length < 0) values_.fail(fmt::format("list {} has the length {}", in_quotes(list.name), length));
    return static_cast<std::uint64_t>(length);
  }

  const Header& header_;
  ValueReader& values_;
  std::uint64_t vertex_count_ = 0;
  Mesh mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Mesh read_ply(const std::string& file, std::string_view content) {
  std::string_view rest = content;
  const Header header = HeaderReader(file, rest).read();
  ValueReader values(file, content, rest, header);
  return BodyReader(header, values).read();
}

}  // namespace softcd::mesh_tools
