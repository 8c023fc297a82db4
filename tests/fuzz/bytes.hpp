#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace softcd::test {

/// The fuzzer's bytes, read from the front; zeros after their end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  bool empty() const { return left_ == 0; }

  template <class T>
  T take() {
    T value{};
    const std::size_t size = left_ < sizeof(T) ? left_ : sizeof(T);
    std::memcpy(&value, data_, size);
    data_ += size;
    left_ -= size;
    return value;
  }
  std::uint32_t below(std::uint32_t count) { return take<std::uint8_t>() % count; }
  bool one_in(std::uint32_t count) { return below(count) == 1; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/// Ends the program where a guarantee does not hold, so that the fuzzer keeps the input.
inline void require(bool holds, const std::string& promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise.c_str());
  std::abort();
}

}  // namespace softcd::test
