#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>
#include <utility>

namespace softcd {

/// The bytes that a detector holds in its backend's memory, the most that it held at once, and a bound on them.
class MemoryAccount {
 public:
  /// Sets the limit; 0 for none. While more is held, nothing can be taken. Resets peak_bytes().
  void set_limit(std::uint64_t bytes) {
    limit_ = bytes == 0 ? kNone : bytes;
    peak_bytes_ = bytes_;
    forget_refusals();
  }
  bool is_limited() const { return limit_ != kNone; }
  /// The argument of set_limit.
  std::uint64_t limit() const { return is_limited() ? limit_ : 0; }

  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t peak_bytes() const { return peak_bytes_; }

  /// The total that is available: the limit, or what was held when memory ran out below it.
  std::uint64_t available() const { return available_; }
  /// The bytes that would be held if the request that was refused last had been granted; 0 if none was refused.
  std::uint64_t refused_total() const { return refused_total_; }
  void forget_refusals() {
    available_ = limit_;
    refused_total_ = 0;
  }

  /// Calls allocate() if the limit allows `bytes` more, and returns its result. Throws std::bad_alloc.
  template <class Allocate>
  auto take(std::uint64_t bytes, const Allocate& allocate) {
    if (bytes_ > limit_ || bytes > limit_ - bytes_) {
      refused_total_ = bytes_ + bytes;
      throw std::bad_alloc();
    }
    try {
      auto memory = allocate();
      bytes_ += bytes;
      peak_bytes_ = std::max(peak_bytes_, bytes_);
      return memory;
    } catch (const std::bad_alloc&) {
      available_ = std::min(available_, bytes_);
      refused_total_ = bytes_ + bytes;
      throw;
    }
  }
  void give_back(std::uint64_t bytes) { bytes_ -= bytes; }

 private:
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

  std::uint64_t limit_ = kNone;
  std::uint64_t available_ = kNone;
  std::uint64_t bytes_ = 0;
  std::uint64_t peak_bytes_ = 0;
  std::uint64_t refused_total_ = 0;
};

/// Memory that is on an account for as long as it is held.
template <class Memory>
class AccountedMemory {
 public:
  AccountedMemory() = default;
  template <class Allocate>
  AccountedMemory(MemoryAccount& account, std::uint64_t bytes, const Allocate& allocate)
      : memory_(account.take(bytes, allocate)), account_(&account), bytes_(bytes) {}
  AccountedMemory(AccountedMemory&& other) noexcept
      : memory_(std::move(other.memory_)),
        account_(std::exchange(other.account_, nullptr)),
        bytes_(std::exchange(other.bytes_, 0)) {}
  AccountedMemory& operator=(AccountedMemory&& other) noexcept {
    AccountedMemory taken(std::move(other));
    std::swap(memory_, taken.memory_);
    std::swap(account_, taken.account_);
    std::swap(bytes_, taken.bytes_);
    return *this;
  }
  ~AccountedMemory() {
    if (account_ != nullptr) account_->give_back(bytes_);
  }

  auto get() const { return memory_.get(); }

 private:
  Memory memory_;
  MemoryAccount* account_ = nullptr;
  std::uint64_t bytes_ = 0;
};

}  // namespace softcd
