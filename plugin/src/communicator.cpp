#include "softcd/communicator.hpp"

#include <fmt/format.h>

#include <utility>

#include "guarded.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/meeting_point.hpp"
#include "softcd/pipeline/rank_link.hpp"

namespace softcd {
namespace {

void validate_size(int size) {
  if (size < 1) throw InvalidInput(fmt::format("{} ranks were asked for; there must be at least 1.", size));
}

class ThreadLink final : public RankLink {
 public:
  ThreadLink(int rank, std::shared_ptr<MeetingPoint> place) : rank_(rank), place_(std::move(place)) {}

  int rank() const override { return rank_; }
  int size() const override { return place_->size(); }
  void all_gather(const void* mine, std::uint64_t bytes, void* all) override {
    place_->all_gather(rank_, mine, bytes, all);
  }

 private:
  int rank_;
  std::shared_ptr<MeetingPoint> place_;
};

class CallerLink final : public RankLink {
 public:
  CallerLink(int rank, int size, Communicator::AllGather all_gather)
      : rank_(rank), size_(size), all_gather_(std::move(all_gather)) {}

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void all_gather(const void* mine, std::uint64_t bytes, void* all) override {
    call_back(all_gather_, mine, static_cast<std::size_t>(bytes), all);
  }

 private:
  int rank_;
  int size_;
  Communicator::AllGather all_gather_;
};

void require_nccl() {
  const std::string problem = nccl_problem();
  if (!problem.empty()) throw BackendError(fmt::format("NCCL cannot be used: {}.", problem));
}

/// Calls f, which makes links, and converts its errors.
template <class F>
auto made(const F& f) {
  try {
    return f();
  } catch (const LinkError& error) {
    throw BackendError(error.what());
  } catch (const DeviceError& error) {
    throw BackendError(error.what());
  }
}

}  // namespace

Communicator::Communicator(std::shared_ptr<RankLink> link) : link_(std::move(link)) {}

Communicator::Communicator(int rank, int size, AllGather all_gather) {
  validate_size(size);
  if (rank < 0 || rank >= size) {
    throw InvalidInput(fmt::format("rank is {} of {}; ranks count from 0.", rank, size));
  }
  if (!all_gather) throw InvalidInput("all_gather is empty; give a function that works like MPI_Allgather.");
  link_ = std::make_shared<CallerLink>(rank, size, std::move(all_gather));
}

std::vector<Communicator> Communicator::of_threads(int size, std::chrono::milliseconds patience) {
  validate_size(size);
  const auto place = std::make_shared<MeetingPoint>(size, patience);
  std::vector<Communicator> ranks;
  ranks.reserve(static_cast<std::size_t>(size));
  for (int rank = 0; rank < size; ++rank) ranks.push_back(Communicator(std::make_shared<ThreadLink>(rank, place)));
  return ranks;
}

Communicator Communicator::of_nccl(void* comm, void* stream, std::chrono::milliseconds patience) {
  require_nccl();
  return Communicator(made([&] { return make_nccl_link(comm, stream, patience); }));
}

std::vector<Communicator> Communicator::of_devices(Span<const int> devices, std::chrono::milliseconds patience) {
  validate_size(static_cast<int>(devices.size()));
  require_nccl();
  std::vector<Communicator> ranks;
  for (std::shared_ptr<RankLink>& link : made([&] { return make_nccl_links(devices, patience); })) {
    ranks.push_back(Communicator(std::move(link)));
  }
  return ranks;
}

int Communicator::rank() const {
  return link_ == nullptr ? 0 : link_->rank();
}

int Communicator::size() const {
  return link_ == nullptr ? 1 : link_->size();
}

}  // namespace softcd
