#pragma once

#include <cstddef>
#include <cstdint>

namespace softcd {

/// The FNV-1a hash of values without padding, one after another.
class Fnv1a {
 public:
  template <class... Values>
  void add(const Values&... values) {
    (add_bytes(&values, sizeof(values)), ...);
  }
  void add_bytes(const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      value_ = (value_ ^ std::uint64_t{static_cast<const unsigned char*>(data)[i]}) * 0x100000001B3U;
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

}  // namespace softcd
