#include "fuzzed_meshes.hpp"

#include <cmath>
#include <limits>

namespace softcd::test {
namespace {

constexpr int kLargestExponent = 20;

/// Returns a power of two, over 12 orders of magnitude.
double fuzzed_scale(Bytes& bytes) {
  return std::ldexp(1.0, static_cast<int>(bytes.below(2 * kLargestExponent + 1)) - kLargestExponent);
}

/// Returns a coordinate that fits a float.
double fuzzed_coordinate(Bytes& bytes, double scale) {
  const auto value = bytes.take<std::int16_t>();
  switch (value) {
    case 0x7FFF:
      return std::numeric_limits<double>::quiet_NaN();
    case 0x7FFE:
      return std::numeric_limits<double>::infinity();
    case 0x7FFD:
      return static_cast<double>(3e38F);
    case 0x7FFC:
      return static_cast<double>(std::numeric_limits<float>::denorm_min());
    default:
      return scale * value / 256.0;
  }
}

float fuzzed_length(Bytes& bytes) {
  if (bytes.one_in(3)) return 0.0F;
  if (bytes.one_in(64)) return bytes.take<float>();
  return static_cast<float>(fuzzed_scale(bytes) * bytes.take<std::uint8_t>() / 64.0);
}

/// Returns an enumerator, or seldom an invalid value.
template <class Enum>
Enum fuzzed_choice(Bytes& bytes, std::uint32_t count) {
  const std::uint32_t value = bytes.take<std::uint8_t>();
  return static_cast<Enum>(value >= 0xFE ? value : value % count);
}

}  // namespace

std::vector<Triangle> fuzzed_triangles(Bytes& bytes, std::uint32_t* vertex_count) {
  const std::uint32_t kind = bytes.below(5);
  const std::uint32_t count = bytes.below(25);
  std::vector<Triangle> triangles;
  *vertex_count = kind == 0 ? 3 + bytes.below(30) : kind == 3 ? 2 * (count + 2) : count + 2;
  for (std::uint32_t i = 0; i < count; ++i) {
    switch (kind) {
      case 0: {
        const auto index = [&] { return bytes.below(*vertex_count); };
        const std::uint32_t a = index();
        const std::uint32_t b = index();
        triangles.push_back({{a, b, index()}});
        break;
      }
      case 1:
        triangles.push_back({{0, i, i + 1}});
        break;
      case 2:
        triangles.push_back({{i, i + 1, i % 3 == 0 ? i : i + 1}});
        break;
      case 3:
        triangles.push_back({{i, i + 1, i + count + 2}});
        break;
      default:
        triangles.push_back({{i, i + 1, i == 0 ? i : i - 1}});
        break;
    }
  }
  if (bytes.one_in(50)) *vertex_count = bytes.below(8);  // triangles may have indices beyond it
  return triangles;
}

Positions3 fuzzed_positions(Bytes& bytes, std::uint32_t count) {
  Positions3 x;
  const double scale = fuzzed_scale(bytes);
  const bool has_many_scales = bytes.one_in(8);
  const bool is_flat = bytes.one_in(6);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double own = has_many_scales ? fuzzed_scale(bytes) : scale;
    const double first = fuzzed_coordinate(bytes, own);
    const double second = fuzzed_coordinate(bytes, own);
    x.push_back({first, second, is_flat ? 0.0 : fuzzed_coordinate(bytes, own)});
  }
  return x;
}

Positions3 fuzzed_motion(Bytes& bytes, const Positions3& x) {
  const std::uint32_t kind = bytes.below(4);
  if (kind == 0) return x;
  if (kind == 1) return fuzzed_positions(bytes, static_cast<std::uint32_t>(x.size()));
  const double scale = fuzzed_scale(bytes);
  const double first = fuzzed_coordinate(bytes, scale);
  const double second = fuzzed_coordinate(bytes, scale);
  const Vec3d offset{first, second, fuzzed_coordinate(bytes, scale)};
  Positions3 moved;
  for (const Vec3d& p : x) {
    const Vec3d q = kind == 2 || bytes.one_in(2) ? p + offset : p;
    moved.push_back({double(float(q.x)), double(float(q.y)), double(float(q.z))});
  }
  return moved;
}

BodySettings fuzzed_settings(Bytes& bytes) {
  BodySettings settings;
  settings.margin = fuzzed_length(bytes);
  settings.self_collision = bytes.below(2) != 0;
  settings.kinematic = bytes.one_in(8);
  settings.features = {!bytes.one_in(6), !bytes.one_in(6)};
  if (bytes.one_in(6)) {
    settings.filter_group = bytes.take<std::uint8_t>();
    settings.filter_mask = bytes.take<std::uint8_t>();
  }
  return settings;
}

QueryOptions fuzzed_options(Bytes& bytes) {
  QueryOptions options;
  options.detection = fuzzed_choice<Detection>(bytes, 2);
  options.accuracy = fuzzed_choice<Accuracy>(bytes, 3);
  options.broad_phase = fuzzed_choice<BroadPhase>(bytes, 2);
  options.subdivision = !bytes.one_in(4);
  if (bytes.one_in(6))
    options.cell_size_factor = bytes.one_in(8) ? bytes.take<float>() : 0.1F * float(1 + bytes.below(40));
  if (bytes.one_in(6)) options.motion_margin = fuzzed_length(bytes);
  if (bytes.one_in(6)) options.contact_rule = fuzzed_choice<ContactRule>(bytes, 3);
  if (bytes.one_in(6)) options.step_end = fuzzed_choice<StepEnd>(bytes, 2);
  options.margins = !bytes.one_in(4);
  options.features = {!bytes.one_in(8), !bytes.one_in(8)};
  options.reuse_pairs = !bytes.one_in(4);
  return options;
}

}  // namespace softcd::test
