#include "certificate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mesh_tools/mesh_io.hpp"
#include "softcd/version.hpp"

namespace softcd::demo {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "softcd-certificate 1";

const char* name_of(Verdict verdict) {
  return verdict == Verdict::proved ? "proved" : (verdict == Verdict::crossed ? "crossed" : "not proved");
}

Json json_of(const ReportedPair& pair) {
  const auto& v = pair.vertices;
  const bool is_vertex_triangle = pair.kind == ContactKind::vertex_triangle;
  const Json a = is_vertex_triangle ? Json{v[0]} : Json{v[0], v[1]};
  const Json b = is_vertex_triangle ? Json{v[1], v[2], v[3]} : Json{v[2], v[3]};
  return {{"kind", is_vertex_triangle ? "vt" : "ee"},
          {"a", {{"mesh", pair.mesh_a}, {"vertices", a}}},
          {"b", {{"mesh", pair.mesh_b}, {"vertices", b}}},
          {"time", pair.time},
          {"crossed", pair.passes_through}};
}

Json json_of(const TrianglePair& pair) {
  return {{"a", {{"mesh", 0}, {"triangle", pair.triangle_a}}},
          {"b", {{"mesh", pair.mesh_b}, {"triangle", pair.triangle_b}}},
          {"through", pair.is_through}};
}

template <class Pair>
Json json_of(const PairList<Pair>& pairs) {
  Json listed = Json::array();
  for (const Pair& pair : pairs.listed) listed.push_back(json_of(pair));
  return {{"count", pairs.count}, {"listed", listed}};
}

Json json_of(const CertifiedMesh& mesh) {
  Json files = Json::array();
  for (std::size_t i = 0; i < mesh.names.size(); ++i) {
    files.push_back({{"name", mesh.names[i]}, {"sha256", mesh.hashes[i]}});
  }
  return {{"vertices", mesh.vertices}, {"triangles", mesh.triangles}, {"files", files}};
}

Json json_of(const StepResult& step, std::size_t index) {
  Json json = {{"from", index}, {"to", index + 1}, {"verdict", name_of(step.verdict)}};
  if (step.pairs.count > 0) json["pairs"] = json_of(step.pairs);
  if (step.changed.count > 0) json["changed_intersections"] = json_of(step.changed);
  return json;
}

/// Returns whether a value holds lists of objects, which get a line each.
bool has_rows(const Json& json) {
  const auto is_list = [](const Json& value) {
    return value.is_array() && !value.empty() && value.front().is_object();
  };
  return is_list(json) || std::any_of(json.begin(), json.end(),
                                      [](const Json& value) { return value.is_structured() && has_rows(value); });
}

std::string in_one_line(const Json& json) {
  // File names may hold any bytes.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Returns JSON with a line for each file, frame, step and pair.
std::string in_rows(const Json& json, const std::string& indent) {
  if (!json.is_structured() || (!indent.empty() && !has_rows(json))) return in_one_line(json);
  const std::string inner = indent + " ";
  std::string text;
  for (auto value = json.begin(); value != json.end(); ++value) {
    text += (text.empty() ? "\n" : ",\n") + inner;
    if (json.is_object()) text += in_one_line(value.key()) + ": ";
    text += in_rows(*value, inner);
  }
  return (json.is_object() ? "{" : "[") + text + "\n" + indent + (json.is_object() ? "}" : "]");
}

std::string describe(const ReportedPair& pair, const CertifyOptions& options) {
  const auto& v = pair.vertices;
  const auto of_mesh = [](std::uint32_t mesh) { return mesh == 0 ? "" : fmt::format(" of mesh {}", mesh); };
  const char* const verb = pair.passes_through ? "crosses" : (options.margin > 0 ? "is near" : "may touch");
  if (pair.kind == ContactKind::vertex_triangle) {
    return fmt::format("vertex {}{} {} triangle {} {} {}{} at {:.6g} of the step", v[0], of_mesh(pair.mesh_a), verb,
                       v[1], v[2], v[3], of_mesh(pair.mesh_b), pair.time);
  }
  return fmt::format("edge {} {}{} {} edge {} {}{} at {:.6g} of the step", v[0], v[1], of_mesh(pair.mesh_a), verb, v[2],
                     v[3], of_mesh(pair.mesh_b), pair.time);
}

std::string describe(const TrianglePair& pair) {
  const std::string other =
      pair.mesh_b == 0 ? std::to_string(pair.triangle_b) : fmt::format("{} of mesh {}", pair.triangle_b, pair.mesh_b);
  return fmt::format("triangles {} and {} {}", pair.triangle_a, other, pair.is_through ? "intersect" : "touch");
}

void print_step(const Certificate& certificate, std::size_t index) {
  const StepResult& step = certificate.steps[index];
  const auto& names = certificate.meshes[0].names;
  const CertifyOptions& options = certificate.options;
  const std::string event = options.margin > 0
                                ? fmt::format("come within {} or within rounding of it", 2 * options.margin)
                                : std::string("touch or come within rounding of touching");
  fmt::print("{} to {}: {}: {} pairs {}\n", names[index], names[index + 1], name_of(step.verdict), step.pairs.count,
             event);
  if (!step.pairs.listed.empty()) fmt::print("  {}\n", describe(step.pairs.listed.front(), options));
}

std::size_t count_of(const Certificate& certificate, Verdict verdict) {
  const auto& steps = certificate.steps;
  return static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(), [&](const StepResult& step) { return step.verdict == verdict; }));
}

std::size_t intersecting_frames(const Certificate& certificate) {
  const auto& frames = certificate.frames;
  return static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const auto& pairs) { return pairs.count > 0; }));
}

/// Returns the name of the file whose hash a JSON pointer names; else an empty string.
std::string file_with_hash_at(const std::string& path, const Json& json) {
  constexpr std::string_view kHash = "/sha256";
  if (path.size() < kHash.size() || path.compare(path.size() - kHash.size(), kHash.size(), kHash) != 0) return {};
  const Json::json_pointer name(path.substr(0, path.size() - kHash.size()) + "/name");
  return json.contains(name) && json[name].is_string() ? json[name].get<std::string>() : std::string();
}

}  // namespace

bool Certificate::is_proved() const {
  return count_of(*this, Verdict::proved) == steps.size() && intersecting_frames(*this) == 0;
}

std::string claim_of(const CertifyOptions& options) {
  const std::string stays =
      options.margin == 0
          ? std::string("no vertex touches a triangle and no edge an edge")
          : fmt::format("vertices stay more than {} away from triangles and edges from edges", 2 * options.margin);
  return "While all vertices move straight and evenly from each frame to the next, " + stays +
         ", unless they share a vertex; in no frame do triangles intersect";
}

std::string text_of(const Certificate& certificate) {
  const CertifyOptions& options = certificate.options;
  Json json = {
      {"format", kFormat},
      {"softcd", SOFTCD_VERSION_STRING},
      {"verdict", certificate.is_proved() ? "proved" : "not proved"},
      {"claim", claim_of(options)},
      {"scope",
       "Positions are those of the files, as doubles. Mesh 0 is compared with itself and with each other mesh"},
      {"arithmetic", {{"steps", "conservative"}, {"frames", "exact"}}},
      {"options", {{"margin", options.margin}, {"every", options.every}, {"list", options.list}}},
      {"proved_steps", count_of(certificate, Verdict::proved)},
      {"crossed_steps", count_of(certificate, Verdict::crossed)},
      {"not_proved_steps", count_of(certificate, Verdict::not_proved)},
      {"intersecting_frames", intersecting_frames(certificate)},
      {"meshes", Json::array()},
      {"frames", Json::array()},
      {"steps", Json::array()}};
  for (const CertifiedMesh& mesh : certificate.meshes) json["meshes"].push_back(json_of(mesh));
  for (std::size_t i = 0; i < certificate.frames.size(); ++i) {
    Json frame = {{"frame", i}, {"intersections", certificate.frames[i].count}};
    if (certificate.frames[i].count > 0) frame["pairs"] = json_of(certificate.frames[i])["listed"];
    json["frames"].push_back(frame);
  }
  for (std::size_t i = 0; i < certificate.steps.size(); ++i) json["steps"].push_back(json_of(certificate.steps[i], i));
  return in_rows(json, "") + "\n";
}

void print_summary(const Certificate& certificate) {
  for (std::size_t i = 0; i < certificate.frames.size(); ++i) {
    const PairList<TrianglePair>& pairs = certificate.frames[i];
    if (i > 0 && certificate.steps[i - 1].verdict != Verdict::proved) print_step(certificate, i - 1);
    if (pairs.count == 0) continue;
    fmt::print("{}: {} pairs of triangles have a point in common\n", certificate.meshes[0].names[i], pairs.count);
    if (!pairs.listed.empty()) fmt::print("  {}\n", describe(pairs.listed.front()));
  }
  fmt::print("{}: {} of {} steps proved, {} crossed, {} not proved; {} of {} frames intersect\n",
             certificate.is_proved() ? "proved" : "not proved", count_of(certificate, Verdict::proved),
             certificate.steps.size(), count_of(certificate, Verdict::crossed),
             count_of(certificate, Verdict::not_proved), intersecting_frames(certificate), certificate.frames.size());
  if (certificate.is_proved()) fmt::print("{}.\n", claim_of(certificate.options));
}

WrittenCertificate read_certificate(const std::string& file) {
  WrittenCertificate written{file, mesh_tools::read_mesh_content(file), {}, {}};
  try {
    const Json json = Json::parse(written.text);
    if (json.at("format") != kFormat) throw mesh_tools::MeshError(fmt::format("{}: is not a '{}'", file, kFormat));
    const Json& options = json.at("options");
    options.at("margin").get_to(written.options.margin);
    options.at("every").get_to(written.options.every);
    options.at("list").get_to(written.options.list);
    for (const Json& mesh : json.at("meshes")) written.frame_counts.push_back(mesh.at("files").size());
    if (!(written.options.margin >= 0) || written.options.every == 0 || written.frame_counts.empty()) {
      throw mesh_tools::MeshError(fmt::format("{}: has options that softcd-certify does not write", file));
    }
  } catch (const Json::exception&) {
    throw mesh_tools::MeshError(fmt::format("{}: is not a certificate that softcd-certify --json has written", file));
  }
  return written;
}

std::string difference(const WrittenCertificate& written, const std::string& text) {
  if (written.text == text) return {};
  const Json before = Json::parse(written.text);
  const Json now = Json::parse(text);
  const Json changes = Json::diff(before, now);
  if (changes.empty()) return "the layout of the text is different";
  // Files first: they may be the cause of all other changes.
  for (const Json& change : changes) {
    const std::string file = file_with_hash_at(change.at("path").get<std::string>(), now);
    if (!file.empty()) return fmt::format("{} has other content", file);
  }
  const std::string path = changes[0].at("path").get<std::string>();
  const Json::json_pointer place(path);
  const auto value_in = [&](const Json& json) { return json.contains(place) ? json[place].dump() : "absent"; };
  return fmt::format("{} was {} and is now {}", path, value_in(before), value_in(now));
}

}  // namespace softcd::demo
