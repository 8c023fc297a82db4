#include "native/tree_shape.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace softcd::bullet {
namespace {

/// Limits the rounds. A cloth of a million nodes takes about 30; a star would take as many as it has nodes.
constexpr int kMostRounds = 64;
constexpr int kNone = -1;

using Pairs = std::vector<std::pair<int, int>>;

Pairs pairs_of_neighbours(const NeighbourLists& lists) {
  Pairs pairs;
  std::vector<char> is_joined(static_cast<std::size_t>(lists.count()), 0);
  for (int i = 0; i < lists.count(); ++i) {
    if (is_joined[static_cast<std::size_t>(i)] != 0) continue;
    is_joined[static_cast<std::size_t>(i)] = 1;
    const Span<const int> neighbours = lists.of(i);
    const auto free = std::find_if(neighbours.begin(), neighbours.end(),
                                   [&](int place) { return is_joined[static_cast<std::size_t>(place)] == 0; });
    pairs.emplace_back(i, free != neighbours.end() ? *free : kNone);
    if (free != neighbours.end()) is_joined[static_cast<std::size_t>(*free)] = 1;
  }
  return pairs;
}

Pairs pairs_in_order(int count) {
  Pairs pairs;
  for (int i = 0; i < count; i += 2) pairs.emplace_back(i, i + 1 < count ? i + 1 : kNone);
  return pairs;
}

/// Two pairs are neighbours if a member of one is a neighbour of a member of the other.
NeighbourLists lists_of_pairs(const NeighbourLists& lists, const Pairs& pairs) {
  std::vector<int> pair_of(static_cast<std::size_t>(lists.count()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    for (const int member : {pairs[p].first, pairs[p].second}) {
      if (member != kNone) pair_of[static_cast<std::size_t>(member)] = static_cast<int>(p);
    }
  }
  Pairs neighbours;
  for (int i = 0; i < lists.count(); ++i) {
    for (const int other : lists.of(i)) {
      const int a = pair_of[static_cast<std::size_t>(i)];
      const int b = pair_of[static_cast<std::size_t>(other)];
      if (a < b) neighbours.emplace_back(a, b);
    }
  }
  NeighbourLists result(static_cast<int>(pairs.size()), neighbours);
  result.sort();
  return result;
}

}  // namespace

NeighbourLists::NeighbourLists(int count, Span<const std::pair<int, int>> pairs)
    : first_(static_cast<std::size_t>(count) + 1, 0), neighbours_(2 * pairs.size()) {
  for (const auto& [a, b] : pairs) {
    ++first_[static_cast<std::size_t>(a) + 1];
    ++first_[static_cast<std::size_t>(b) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (const auto& [a, b] : pairs) {
    neighbours_[static_cast<std::size_t>(next[static_cast<std::size_t>(a)]++)] = b;
    neighbours_[static_cast<std::size_t>(next[static_cast<std::size_t>(b)]++)] = a;
  }
}

Span<const int> NeighbourLists::of(int place) const {
  const auto first = static_cast<std::size_t>(first_[static_cast<std::size_t>(place)]);
  const auto last = static_cast<std::size_t>(first_[static_cast<std::size_t>(place) + 1]);
  return {neighbours_.data() + first, last - first};
}

void NeighbourLists::sort() {
  auto end = neighbours_.begin();
  int first = 0;
  for (std::size_t place = 0; place + 1 < first_.size(); ++place) {
    const auto begin = neighbours_.begin() + first;
    first = first_[place + 1];
    const auto old_end = neighbours_.begin() + first;
    std::sort(begin, old_end);
    end = std::copy(begin, std::unique(begin, old_end), end);
    first_[place + 1] = static_cast<int>(end - neighbours_.begin());
  }
  neighbours_.erase(end, neighbours_.end());
}

bool is_connected(const NeighbourLists& lists) {
  if (lists.count() == 0) return true;
  std::vector<char> is_reached(static_cast<std::size_t>(lists.count()), 0);
  std::vector<int> reached = {0};
  is_reached[0] = 1;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const int neighbour : lists.of(reached[i])) {
      if (std::exchange(is_reached[static_cast<std::size_t>(neighbour)], 1) == 0) reached.push_back(neighbour);
    }
  }
  return reached.size() == is_reached.size();
}

TreeShape tree_shape(NeighbourLists lists) {
  TreeShape shape;
  std::vector<int> roots(static_cast<std::size_t>(lists.count()));
  std::iota(roots.begin(), roots.end(), 0);
  const int leaf_count = lists.count();
  for (int round = 0; roots.size() > 1; ++round) {
    Pairs pairs;
    if (round < kMostRounds) pairs = pairs_of_neighbours(lists);
    const bool has_joined = !pairs.empty() && pairs.size() < roots.size();
    if (!has_joined) pairs = pairs_in_order(static_cast<int>(roots.size()));
    std::vector<int> joined;
    for (const auto& [a, b] : pairs) {
      joined.push_back(roots[static_cast<std::size_t>(a)]);
      if (b == kNone) continue;
      shape.emplace_back(joined.back(), roots[static_cast<std::size_t>(b)]);
      joined.back() = leaf_count + static_cast<int>(shape.size()) - 1;
    }
    lists = lists_of_pairs(lists, pairs);
    roots = std::move(joined);
  }
  return shape;
}

}  // namespace softcd::bullet
