#include "body_questions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "validation.hpp"

namespace softcd::detail {
namespace {

struct Triangles {
  std::uint32_t first, count;
};

Triangles triangles_of(std::uint32_t number, Span<const ProbedBody> bodies) {
  if (number != kNoIndex) {
    const ProbedBody& body = bodies[number];
    return {body.first_triangle, body.is_asked ? body.triangle_count : 0};
  }
  std::uint32_t end = 0;
  for (const ProbedBody& body : bodies) {
    if (body.is_asked) end = std::max(end, body.first_triangle + body.triangle_count);
  }
  return {0, end};
}

void add_partner(BodiesQuestion& question, std::uint32_t number) {
  const BodyClasses own = class_of(number);
  question.repeated_partners = static_cast<BodyClasses>(question.repeated_partners | (question.partners & own));
  question.partners = static_cast<BodyClasses>(question.partners | own);
}

}  // namespace

std::uint32_t number_of(BodyId id, Span<const ProbedBody> bodies) {
  if (id == BodyId()) return kNoIndex;
  const ProbedBody* const body =
      std::lower_bound(bodies.begin(), bodies.end(), id.value,
                       [](const ProbedBody& candidate, std::uint32_t value) { return candidate.id < value; });
  return static_cast<std::uint32_t>(body - bodies.begin());
}

void BodyQuestions::prepare(Span<const ProbeBodies> asked, Span<const ProbedBody> bodies) {
  BodiesQuestion all{};
  for (std::uint32_t number = 0; number < bodies.size(); ++number) {
    if (bodies[number].is_asked) add_partner(all, number);
  }
  questions_.clear();
  item_count_ = 0;
  for (const ProbeBodies& pair : asked) {
    BodiesQuestion question = all;
    question.a = number_of(pair.a, bodies);
    question.b = number_of(pair.b, bodies);
    if (question.b != kNoIndex) {
      question.partners = class_of(question.b);
      // Triangles of other bodies request it, whatever their class.
      question.repeated_partners = question.a == question.b ? BodyClasses{0} : question.partners;
    }
    const Triangles triangles = triangles_of(question.a, bodies);
    question.first_triangle = triangles.first;
    question.first_item = item_count_;
    questions_.push_back(question);
    item_count_ += triangles.count;
  }
  if (item_count_ >= kMostElements) {
    throw InvalidInput(
        fmt::format("{} pairs of bodies with {} triangles in all are more than 2^31; ask in several calls.",
                    asked.size(), item_count_));
  }
}

}  // namespace softcd::detail
