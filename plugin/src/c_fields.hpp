#pragma once

#include "c_interface.hpp"
#include "softcd/fields/options.hpp"

/// Copies between the structs of softcd.h and those of softcd.hpp. Members of one name have one meaning.
namespace softcd::c_interface {

template <class A, class B>
constexpr bool have_equal_names(const A& /*a*/, const B& /*b*/) {
  return std::string_view(A::kName) == B::kName;
}

/// Returns the number of members of A that B lacks, by name.
template <class A, class B>
constexpr int missing_members() {
  int missing = 0;
  for_each_field<A>([&](auto a) {
    bool is_found = false;
    for_each_field<B>([&](auto b) { is_found |= have_equal_names(a, b); });
    missing += is_found ? 0 : 1;
  });
  return missing;
}
template <class C, class Struct>
inline constexpr std::array kMissing = {missing_members<C, Struct>(), missing_members<Struct, C>()};
// struct_size is C's alone; `communicator` is not in C, nor are the grid's counts; `total_ms` is ms.total.
static_assert(kMissing<softcd_scene_options, SceneOptions> == std::array{1, 1});
static_assert(kMissing<softcd_body_settings, BodySettings> == std::array{1, 0});
static_assert(kMissing<softcd_query_options, QueryOptions> == std::array{1, 0});
static_assert(kMissing<softcd_statistics, Statistics> == std::array{2, 12});

/// Copies members to those of the same name.
template <class From, class To>
void copy_members(const From& from, To& to) {
  for_each_field<From>([&](auto source) {
    for_each_field<To>([&](auto target) {
      if constexpr (have_equal_names(source, target)) {
        target.of(to) = static_cast<typename decltype(target)::Value>(source.of(from));
      }
    });
  });
}

template <class C, class Struct>
C to_c(const Struct& from) {
  C to{};
  to.struct_size = sizeof(C);
  copy_members(from, to);
  return to;
}

/// Returns the given struct in C++'s form, or the defaults for null.
template <class Struct, class C>
Struct from_c(const C* given, const char* argument) {
  Struct to;
  if (given != nullptr) copy_members(sized(given, argument), to);
  return to;
}

}  // namespace softcd::c_interface
