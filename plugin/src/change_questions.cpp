#include "change_questions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "body_questions.hpp"
#include "validation.hpp"

namespace softcd::detail {
namespace {

void validate_change(std::size_t index, const ProbeChange& change, const ProbedBody& body) {
  const auto problem = [&](std::string_view text) {
    return InvalidInput(fmt::format("change {} of body {}: {}", index, change.body.value, text));
  };
  if (!body.has_positions) throw problem("it has no positions; use set_positions() first.");
  for (const std::uint32_t triangle : change.removed) {
    if (triangle < body.triangle_count) continue;
    throw problem(fmt::format("triangle {} is to be removed, but the body has {}; indices count from 0.", triangle,
                              body.triangle_count));
  }
  const std::uint64_t vertex_count = body.vertex_count + change.new_vertices.size();
  for (std::size_t i = 0; i < change.added.size(); ++i) {
    for (const std::uint32_t v : change.added[i].v) {
      if (v < vertex_count) continue;
      throw problem(fmt::format("added triangle {} has vertex index {}, but there are {} vertices and {} new ones.", i,
                                v, body.vertex_count, change.new_vertices.size()));
    }
  }
  for (std::size_t i = 0; i < change.new_vertices.size(); ++i) {
    if (!is_usable(change.new_vertices[i])) throw problem(fmt::format("new vertex {} is not finite.", i));
  }
}

}  // namespace

void ChangesInQuestion::prepare(Span<const ProbeChange> changes, Span<const ProbedBody> bodies) {
  changes_.clear();
  removed_.clear();
  added_.clear();
  new_vertices_.clear();
  for (std::size_t i = 0; i < changes.size(); ++i) add(i, changes[i], bodies);
  const std::size_t most = std::max({removed_.size(), added_.size(), new_vertices_.size()});
  if (most >= kMostElements) {
    throw InvalidInput(
        fmt::format("{} triangles or vertices in one batch of changes are more than 2^31; ask in "
                    "several.",
                    most));
  }
}

void ChangesInQuestion::add(std::size_t index, const ProbeChange& change, Span<const ProbedBody> bodies) {
  const std::uint32_t number = number_of(change.body, bodies);
  const ProbedBody& body = bodies[number];
  validate_change(index, change, body);
  ChangeQuestion question{};
  question.body = number;
  question.removed_begin = static_cast<std::uint32_t>(removed_.size());
  for (const std::uint32_t triangle : change.removed) removed_.push_back(body.first_triangle + triangle);
  std::sort(removed_.begin() + question.removed_begin, removed_.end());
  question.removed_end = static_cast<std::uint32_t>(removed_.size());
  const auto first_new = static_cast<std::uint32_t>(new_vertices_.size());
  question.first_item = added_.size();
  for (Triangle triangle : change.added) {
    for (std::uint32_t& v : triangle.v) {
      v = v < body.vertex_count ? body.first_vertex + v : kNewVertex | (first_new + (v - body.vertex_count));
    }
    added_.push_back(triangle);
  }
  question.end_item = added_.size();
  new_vertices_.insert(new_vertices_.end(), change.new_vertices.begin(), change.new_vertices.end());
  changes_.push_back(question);
}

}  // namespace softcd::detail
