// Names of C++20 that the libc++ of Emscripten 3.1.6 lacks, as far as softcd uses them and one thread needs them.
#pragma once

#if __cplusplus >= 202002L

#include <charconv>
#include <cstdlib>
#include <string>
#include <type_traits>

namespace std {

template <class T>
class atomic_ref {
 public:
  explicit atomic_ref(T& value) : value_(&value) {}
  template <class... Order>
  T fetch_add(T added, Order... /*order*/) const {
    return __atomic_fetch_add(value_, added, __ATOMIC_RELAXED);
  }

 private:
  T* value_;
};

template <class To, class From>
constexpr To bit_cast(const From& from) {
  static_assert(sizeof(To) == sizeof(From) && is_trivially_copyable_v<From> && is_trivially_copyable_v<To>);
  return __builtin_bit_cast(To, from);
}

inline from_chars_result from_chars(const char* begin, const char* end, double& value) {
  const string text(begin, end);
  char* text_end = nullptr;
  const double read = strtod(text.c_str(), &text_end);
  if (text_end == text.c_str()) return {begin, errc::invalid_argument};
  value = read;
  return {begin + (text_end - text.c_str()), errc{}};
}

}  // namespace std

#endif
