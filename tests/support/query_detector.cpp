#include "query_detector.hpp"

#include <algorithm>

namespace softcd::test {
namespace {

// A point and a triangle, or two segments.
constexpr std::array<Triangle, 2> kVertexAndTriangle = {{{{0, 0, 0}}, {{1, 2, 3}}}};
constexpr std::array<Triangle, 2> kTwoEdges = {{{{0, 1, 1}}, {{2, 3, 3}}}};

bool is_of_query(const Contact& contact) {
  return contact.feature_b == 1 && contact.feature_a == 0;
}

}  // namespace

QueryDetector::QueryDetector(ContactKind kind, const PipelineOptions& options, float margin) : pipeline_(options) {
  const bool is_vertex = kind == ContactKind::vertex_triangle;
  BodySettings settings;
  settings.margin = 0.5F * margin;
  settings.self_collision = true;
  settings.features = {is_vertex, !is_vertex};
  body_ = pipeline_.scene.add_body({is_vertex ? kVertexAndTriangle : kTwoEdges, 4, settings});
}

std::optional<Contact> QueryDetector::detect(const Query& query) {
  const Span<const Vec3d> t0(query.rows.data(), 4);
  const Span<const Vec3d> t1(query.rows.data() + 4, 4);
  pipeline_.scene.set_positions(body_, t0, t1);
  const Span<const Contact> contacts = pipeline_.detect();
  const Contact* const found = std::find_if(contacts.begin(), contacts.end(), is_of_query);
  return found == contacts.end() ? std::nullopt : std::optional<Contact>(*found);
}

}  // namespace softcd::test
