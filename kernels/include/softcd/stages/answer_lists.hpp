#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

/// Lists of answers, one for each question: counted first, then written one behind the other, each in order. `Lister`
/// has list(question, sink), which calls sink.add(make) for each answer make(), and is_before(a, b), a total order.
namespace softcd {

/// A question's first answers are noted when they are counted. Only questions with more answers are asked again: few
/// triangles intersect more others than this.
constexpr std::uint32_t kNotedAnswers = 4;

/// Counts the answers, and notes the first ones.
template <class Lister>
struct CountAnswers {
  using Answer = typename Lister::Answer;

  Lister lister;
  std::uint32_t* counts;
  Answer* noted;  ///< kNotedAnswers for each question

  SOFTCD_HD void operator()(std::uint32_t i) const {
    Counter counter{noted + std::uint64_t{kNotedAnswers} * i};
    lister.list(i, counter);
    counts[i] = counter.count;
  }

 private:
  struct Counter {
    Answer* noted;
    std::uint32_t count = 0;

    template <class Make>
    SOFTCD_HD void add(const Make& make) {
      if (count < kNotedAnswers) noted[count] = make();
      ++count;
    }
  };
};

template <class Lister>
struct WriteAnswers {
  using Answer = typename Lister::Answer;

  Lister lister;
  const std::uint64_t* begins;  ///< of each question's answers, and behind the last question's their end
  const Answer* noted;          ///< by CountAnswers
  Answer* answers;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const auto count = static_cast<std::uint32_t>(begins[i + 1] - begins[i]);
    Writer writer{answers + begins[i]};
    if (count > kNotedAnswers) {
      lister.list(i, writer);
    } else {
      for (std::uint32_t k = 0; k < count; ++k) writer.answers[k] = noted[std::uint64_t{kNotedAnswers} * i + k];
    }
    sort(writer.answers, count);
  }

 private:
  struct Writer {
    Answer* answers;
    std::uint32_t count = 0;

    template <class Make>
    SOFTCD_HD void add(const Make& make) {
      answers[count++] = make();
    }
  };

  static SOFTCD_HD void swap(Answer& a, Answer& b) {
    const Answer kept = a;
    a = b;
    b = kept;
  }

  /// Heapsort: no scratch, and no worst case.
  static SOFTCD_HD void sort(Answer* values, std::uint32_t count) {
    for (std::uint32_t root = count / 2; root-- > 0;) sift(values, root, count);
    for (std::uint32_t end = count; end-- > 1;) {
      swap(values[0], values[end]);
      sift(values, 0, end);
    }
  }

  static SOFTCD_HD void sift(Answer* values, std::uint32_t root, std::uint32_t end) {
    while (2 * root + 1 < end) {
      std::uint32_t child = 2 * root + 1;
      if (child + 1 < end && Lister::is_before(values[child], values[child + 1])) ++child;
      if (!Lister::is_before(values[root], values[child])) return;
      swap(values[root], values[child]);
      root = child;
    }
  }
};

/// Returns the last question that begins at the item or before; see Question::first_item. So questions without items
/// have none.
template <class Question>
SOFTCD_HD std::uint32_t question_of(const Question* questions, std::uint32_t count, std::uint64_t item) {
  std::uint32_t first = 0;
  std::uint32_t last = count;
  while (last - first > 1) {
    const std::uint32_t middle = first + (last - first) / 2;
    (questions[middle].first_item <= item ? first : last) = middle;
  }
  return first;
}

/// Finds where each question's answers begin: where those of its first item do, see Question::first_item. Behind the
/// last question's it writes where all answers end.
template <class Question>
struct GatherBegins {
  const Question* questions;
  const std::uint64_t* item_begins;
  std::uint64_t item_count;
  std::uint64_t question_count;
  std::uint64_t* begins;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    begins[i] = item_begins[questions[i].first_item];
    if (i + 1 == question_count) begins[i + 1] = item_begins[item_count];
  }
};

}  // namespace softcd
