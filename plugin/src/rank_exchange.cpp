#include "rank_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <utility>

#include "softcd/core/fnv.hpp"
#include "softcd/error.hpp"
#include "softcd/fields/options.hpp"
#include "validation.hpp"

namespace softcd {
namespace {

/// Below this number, one GPU detects faster than two GPUs communicate. A cloth on a ball of 100K triangles takes two
/// H200 0.96 to 1.02 of the time of one, of 200K 0.89 to 0.93.
constexpr std::uint64_t kFewestTrianglesOnDevices = 150'000;

/// Adds the values that must be equal on all ranks.
template <class Struct>
void add_fields(Fnv1a& digest, const Struct& object) {
  for_each_field<Struct>([&](auto field) {
    if (!field.kMayDiffer) digest.add(field.of(object));
  });
}

/// The result of a detection on one rank.
enum class Outcome : std::uint32_t { success, invalid_input, backend_error, out_of_memory, other_error };

struct Report {
  Outcome outcome = Outcome::success;
  TestSamples tests;
  std::array<char, 512> text{};  ///< ends with a 0
};

Report report_of(Outcome outcome, const char* text) {
  Report report;
  report.outcome = outcome;
  std::strncpy(report.text.data(), text, report.text.size() - 1);
  return report;
}

Report report_of(const std::exception_ptr& problem) {
  if (problem == nullptr) return {};
  try {
    std::rethrow_exception(problem);
  } catch (const InvalidInput& error) {
    return report_of(Outcome::invalid_input, error.what());
  } catch (const BackendError& error) {
    return report_of(Outcome::backend_error, error.what());
  } catch (const OutOfMemory& error) {
    return report_of(Outcome::out_of_memory, error.what());
  } catch (const std::exception& error) {
    return report_of(Outcome::other_error, error.what());
  } catch (...) {
    return report_of(Outcome::other_error, "an exception that is no std::exception");
  }
}

[[noreturn]] void raise(int rank, const Report& report) {
  const std::string text = fmt::format("rank {}: {}", rank, report.text.data());
  switch (report.outcome) {
    case Outcome::invalid_input:
      throw InvalidInput(text);
    case Outcome::backend_error:
      throw BackendError(text);
    case Outcome::out_of_memory:
      throw OutOfMemory(text);
    default:
      throw Error(text);
  }
}

std::uint64_t element_size(std::uint8_t flags, std::uint8_t is_double) {
  return (flags & is_double) != 0U ? sizeof(Vec3d) : sizeof(Vec3f);
}

void copy_positions(const Positions& from, std::byte* to) {
  const std::size_t size = position_size(from);
  const auto* data = static_cast<const std::byte*>(from.data());
  for (std::size_t i = 0; i < from.count(); ++i) std::memcpy(to + i * size, data + i * from.stride(), size);
}

/// Returns a view of tightly packed positions.
Positions packed(const void* data, std::size_t count, bool is_double) {
  if (is_double) return {static_cast<const double*>(data), count, sizeof(Vec3d)};
  return {static_cast<const float*>(data), count, sizeof(Vec3f)};
}
Positions packed_on_device(const void* data, std::size_t count, bool is_double) {
  if (is_double) return Positions::on_device(static_cast<const double*>(data), count, sizeof(Vec3d));
  return Positions::on_device(static_cast<const float*>(data), count, sizeof(Vec3f));
}

}  // namespace

RankExchange::RankExchange(std::shared_ptr<RankLink> link) : link_(std::move(link)), shares_(link_->size()) {}

void RankExchange::set_positions(const Body& body, const Positions& x_t0, const Positions& x_t1) {
  given_[body.id.value] = {x_t0, x_t1};
}

void RankExchange::forget(BodyId id) {
  given_.erase(id.value);
  blocks_.erase(id.value);
}

template <class F>
void RankExchange::talk(const F& f) {
  try {
    f();
  } catch (const DeviceError& error) {
    throw BackendError(error.what());
  } catch (const LinkError& error) {
    throw Error(
        fmt::format("rank {} of {}: {}. Make new communicators, and make sure that all ranks make the same "
                    "calls in the same order.",
                    link_->rank(), link_->size(), error.what()));
  }
}

template <class T>
std::vector<T> RankExchange::gathered(const T& mine) {
  std::vector<T> all(static_cast<std::size_t>(link_->size()));
  talk([&] { link_->all_gather(&mine, sizeof(T), all.data()); });
  return all;
}

void RankExchange::compare(const std::vector<Body>& bodies, const QueryOptions& options, Pairs pairs) {
  struct Summary {
    std::uint64_t scene, query;
  };
  Fnv1a scene;
  for (const Body& body : bodies) {
    scene.add(body.id.value, body.is_removed, body.rank, body.vertex_count(), body.triangle_count(),
              body.vertex_filters.size(), body.x_rest.size());
    add_fields(scene, body.settings);
  }
  Fnv1a query;
  query.add(pairs);
  add_fields(query, options);
  const Summary mine = {scene.value(), query.value()};
  const std::vector<Summary> all = gathered(mine);
  for (const Summary& summary : all) {
    if (summary.scene != all.front().scene) {
      throw Error("the ranks have different scenes; add the same bodies, with the same settings, on all of them.");
    }
    if (summary.query != all.front().query) {
      throw Error("the ranks start different detections; use queries with the same options on all of them.");
    }
  }
}

/// Returns what was set for each body on its rank.
std::vector<std::uint8_t> RankExchange::gathered_flags(const std::vector<Body>& bodies, const GivenByRank& given) {
  std::vector<std::uint8_t> mine(bodies.size(), 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto it = given.find(bodies[i].id.value);
    if (it == given.end()) continue;
    const auto& [t0, t1] = it->second;
    const bool two = t0.data() != t1.data() || t0.stride() != t1.stride();
    mine[i] = static_cast<std::uint8_t>(is_new | (t1.is_double() ? is_double : 0) | (two ? has_two_ends : 0));
  }
  std::vector<std::uint8_t> all(bodies.size() * static_cast<std::size_t>(link_->size()));
  talk([&] { link_->all_gather(mine.data(), mine.size(), all.data()); });
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    mine[i] = bodies[i].rank < 0 ? std::uint8_t{0} : all[static_cast<std::size_t>(bodies[i].rank) * bodies.size() + i];
  }
  return mine;
}

void RankExchange::meet(const std::vector<Body>& bodies, const QueryOptions& options, Pairs pairs,
                        const SetPositions& set) {
  const GivenByRank given = std::exchange(given_, {});
  compare(bodies, options, pairs);
  const std::vector<std::uint8_t> flags = gathered_flags(bodies, given);
  if (link_->device() >= 0) {
    exchange_on_device(bodies, flags, given, set);
  } else {
    exchange_on_host(bodies, flags, given, set);
  }
}

std::uint64_t RankExchange::bytes_of(const Body& body, std::uint8_t flags) {
  if (flags == 0) return 0;
  return ((flags & has_two_ends) != 0 ? 2U : 1U) * element_size(flags, is_double) * body.vertex_count();
}

/// Reserves so many bytes for each rank, or throws on all ranks.
void RankExchange::reserve_on_host(std::uint64_t bytes) {
  if (bytes <= mine_.size()) return;
  std::exception_ptr problem;
  std::vector<std::byte> mine;
  std::vector<std::byte> all;
  try {
    mine.resize(bytes);
    all.resize(bytes * static_cast<std::uint64_t>(link_->size()));
  } catch (const std::bad_alloc&) {
    problem = std::make_exception_ptr(OutOfMemory(
        fmt::format("memory ran out for a copy of all ranks' positions, {} bytes of each. Free memory.", bytes)));
  }
  agree(problem, {});
  mine_ = std::move(mine);
  all_ = std::move(all);
}

/// Exchanges each rank's positions as one block; all blocks are as long as the longest.
void RankExchange::exchange_on_host(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags,
                                    const GivenByRank& given, const SetPositions& set) {
  const auto ranks = static_cast<std::size_t>(link_->size());
  std::vector<std::uint64_t> block_bytes(ranks, 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (flags[i] != 0) block_bytes[static_cast<std::size_t>(bodies[i].rank)] += bytes_of(bodies[i], flags[i]);
  }
  const std::uint64_t bytes = *std::max_element(block_bytes.begin(), block_bytes.end());
  if (bytes == 0) return;
  // Blocks begin at multiples of a double's size.
  const std::uint64_t stride = (bytes + sizeof(double) - 1) / sizeof(double) * sizeof(double);
  reserve_on_host(stride);
  const auto for_each_given = [&](const auto& f) {
    // Doubles come first, so that they stay aligned.
    std::vector<std::uint64_t> begin(ranks, 0);
    for (const bool doubles : {true, false}) {
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (flags[i] == 0 || ((flags[i] & is_double) != 0) != doubles) continue;
        std::uint64_t& offset = begin[static_cast<std::size_t>(bodies[i].rank)];
        f(i, offset);
        offset += bytes_of(bodies[i], flags[i]);
      }
    }
  };
  for_each_given([&](std::size_t i, std::uint64_t offset) {
    if (bodies[i].rank != link_->rank()) return;
    const auto& [t0, t1] = given.at(bodies[i].id.value);
    copy_positions(t1, mine_.data() + offset);
    if ((flags[i] & has_two_ends) != 0) copy_positions(t0, mine_.data() + offset + bytes_of(bodies[i], flags[i]) / 2);
  });
  talk([&] { link_->all_gather(mine_.data(), stride, all_.data()); });
  for_each_given([&](std::size_t i, std::uint64_t offset) {
    const Body& body = bodies[i];
    const std::byte* data = all_.data() + static_cast<std::uint64_t>(body.rank) * stride + offset;
    const bool doubles = (flags[i] & is_double) != 0;
    const Positions t1 = packed(data, body.vertex_count(), doubles);
    const bool two = (flags[i] & has_two_ends) != 0;
    set(body.id, two ? packed(data + bytes_of(body, flags[i]) / 2, body.vertex_count(), doubles) : t1, t1);
  });
}

/// Reserves a block for each body with new positions, or throws on all ranks. All ranks have had the same blocks
/// before, so they all grow the same ones.
void RankExchange::reserve_on_device(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags) {
  std::map<std::uint32_t, DeviceBlock> grown;
  std::exception_ptr problem;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint64_t bytes = bytes_of(bodies[i], flags[i]);
    const auto it = blocks_.find(bodies[i].id.value);
    if (bytes == 0 || (it != blocks_.end() && it->second.bytes >= bytes)) continue;
    DeviceBlock& block = grown[bodies[i].id.value];
    try {
      if (problem == nullptr) block = {link_->allocate(bytes), bytes};
    } catch (const std::bad_alloc&) {
      problem = std::make_exception_ptr(OutOfMemory(
          fmt::format("body {}: memory ran out for a copy of its positions on the GPU, {} bytes. Free memory.",
                      bodies[i].id.value, bytes)));
    } catch (const DeviceError& error) {
      problem = std::make_exception_ptr(BackendError(error.what()));
    }
  }
  if (grown.empty()) return;
  agree(problem, {});
  for (auto& [id, block] : grown) {
    std::swap(blocks_[id], block);
    retired_.push_back(std::move(block));
  }
}

/// Sends each body's positions from its rank to all others, into memory that the scene reads until they are set again.
void RankExchange::exchange_on_device(const std::vector<Body>& bodies, const std::vector<std::uint8_t>& flags,
                                      const GivenByRank& given, const SetPositions& set) {
  reserve_on_device(bodies, flags);
  std::vector<DeviceBroadcast> broadcasts;
  talk([&] {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (flags[i] == 0) continue;
      const std::uint64_t size = element_size(flags[i], is_double);
      const std::uint64_t count = bodies[i].vertex_count();
      const int ends = (flags[i] & has_two_ends) != 0 ? 2 : 1;
      auto* data = static_cast<std::byte*>(blocks_[bodies[i].id.value].memory.get());
      const auto it = given.find(bodies[i].id.value);
      for (int end = 0; end < ends; ++end) {
        DeviceBroadcast broadcast{
            bodies[i].rank, data + static_cast<std::uint64_t>(end) * size * count, nullptr, false, count, size, size};
        if (it != given.end()) {
          const Positions& x = end == 0 ? it->second.t1 : it->second.t0;
          if (x.ready() != nullptr) link_->wait_for(x.ready());
          broadcast.given = x.data();
          broadcast.is_given_on_device = x.is_on_device();
          broadcast.stride = x.stride();
        }
        broadcasts.push_back(broadcast);
      }
    }
  });
  if (broadcasts.empty()) return;
  talk([&] { link_->broadcast(broadcasts); });
  std::size_t next = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (flags[i] == 0) continue;
    const bool doubles = (flags[i] & is_double) != 0;
    const auto end = [&] { return packed_on_device(broadcasts[next++].data, bodies[i].vertex_count(), doubles); };
    const Positions t1 = end();
    set(bodies[i].id, (flags[i] & has_two_ends) != 0 ? end() : t1, t1);
  }
  retired_.clear();
}

std::uint64_t RankExchange::fewest_triangles() const {
  return link_->device() >= 0 ? kFewestTrianglesOnDevices : 0;
}

bool RankExchange::has_part(std::uint64_t triangles) const {
  return triangles >= fewest_triangles() || link_->rank() == 0;
}

Partition RankExchange::partition(std::uint64_t triangles) const {
  return triangles >= fewest_triangles() ? shares_.of(link_->rank()) : Partition{};
}

/// Throws on all ranks where an error occurred on one; else returns all ranks' tests.
std::vector<TestSamples> RankExchange::agree(const std::exception_ptr& problem, const TestSamples& tests) {
  Report mine = report_of(problem);
  mine.tests = tests;
  const std::vector<Report> all = gathered(mine);
  std::vector<TestSamples> samples;
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    if (all[rank].outcome != Outcome::success) raise(static_cast<int>(rank), all[rank]);
    samples.push_back(all[rank].tests);
  }
  return samples;
}

void RankExchange::conclude(const std::exception_ptr& problem, const TestSamples& tests) {
  const std::vector<TestSamples> samples = agree(problem, tests);
  std::uint64_t sum = 0;
  for (const TestSamples& of_rank : samples) sum += of_rank.tests;
  share_of_tests_ = sum > 0 ? static_cast<double>(tests.tests) / static_cast<double>(sum) : 0.0;
  shares_.balance(samples);
}

std::vector<Contact> RankExchange::gather(Span<const Contact> mine) {
  const std::vector<std::uint64_t> counts = gathered(static_cast<std::uint64_t>(mine.size()));
  const std::uint64_t most = *std::max_element(counts.begin(), counts.end());
  std::vector<Contact> padded(mine.begin(), mine.end());
  padded.resize(most);
  std::vector<Contact> blocks(most * counts.size());
  if (most > 0) talk([&] { link_->all_gather(padded.data(), most * sizeof(Contact), blocks.data()); });
  std::vector<Contact> all;
  for (std::size_t rank = 0; rank < counts.size(); ++rank) {
    const auto begin = blocks.begin() + static_cast<std::ptrdiff_t>(rank * most);
    all.insert(all.end(), begin, begin + static_cast<std::ptrdiff_t>(counts[rank]));
  }
  std::sort(all.begin(), all.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.kind, a.body_a, a.feature_a, a.body_b, a.feature_b) <
           std::tie(b.kind, b.body_a, b.feature_a, b.body_b, b.feature_b);
  });
  return all;
}

}  // namespace softcd
