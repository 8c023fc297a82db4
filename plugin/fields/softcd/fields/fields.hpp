#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

/// Names the members of structs. Everything that handles options one by one is derived from such a list: equality,
/// checks, the comparison between ranks, C, Python, PyBullet and command lines.
namespace softcd {

/// The fields of a struct, a tuple made by fields_of(): specialized for every struct that has such a list.
template <class Struct>
inline constexpr auto kFields = nullptr;

/// The allowed values of a number. Infinity and NaN are never allowed.
struct ValueRange {
  double least = std::numeric_limits<double>::lowest();
  double most = std::numeric_limits<double>::max();
  bool or_zero = false;  ///< 0 is allowed, too
};

/// The allowed values of a member: specialized for those with a limit.
template <auto kMember>
inline constexpr ValueRange kRangeOf = {};

/// The help text of a member, for command lines and Python: specialized for all options.
template <auto kMember>
inline constexpr const char* kHelpOf = nullptr;

/// Whether ranks of a Communicator may have different values: specialized for members that change no contacts.
template <auto kMember>
inline constexpr bool kMayDifferBetweenRanks = false;

/// Whether the fields of a member of this type count as fields of the struct that it is in.
template <class Member>
inline constexpr bool kIsFlattened = false;

/// Returns whether a character can be part of a name.
constexpr bool is_of_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// Returns the last name or number in the template argument that a compiler prints as part of a function's signature:
/// the signature ends in "= &Struct::member]" for g++ and clang, in "->member>(void)" for MSVC.
constexpr std::string_view last_name(std::string_view signature) {
  std::size_t end = std::min(signature.rfind(">(void)"), signature.size());
  while (!is_of_name(signature[end - 1])) --end;
  std::size_t begin = end;
  while (is_of_name(signature[begin - 1])) --begin;
  return signature.substr(begin, end - begin);
}

#if defined(_MSC_VER) && !defined(__clang__)
#define SOFTCD_SIGNATURE __FUNCSIG__
#else
#define SOFTCD_SIGNATURE __PRETTY_FUNCTION__
#endif

/// Returns the compiler's name of an enumerator, or of a member of which it prints the name.
template <auto kConstant>
constexpr auto name_in_source() {
  constexpr std::string_view kName = last_name(SOFTCD_SIGNATURE);
  std::array<char, kName.size() + 1> name{};
  for (std::size_t i = 0; i < kName.size(); ++i) name[i] = kName[i];
  return name;
}
template <auto kConstant>
inline constexpr auto kNameInSource = name_in_source<kConstant>();

#undef SOFTCD_SIGNATURE

#if defined(_MSC_VER) && !defined(__clang__)
// MSVC prints pointers to members as numbers, and the address of an object's member by name. No object is needed for
// it.
template <class Struct>
extern const Struct kNoObject;
template <auto kMember>
inline constexpr auto kMemberName = nullptr;
template <class Struct, class Member, Member Struct::*kMember>
inline constexpr auto kMemberName<kMember> = name_in_source<&(kNoObject<Struct>.*kMember)>();
#else
template <auto kMember>
inline constexpr auto kMemberName = kNameInSource<kMember>;
#endif

/// Returns whether the compiler has printed a number without a name, as a cast: "(Enum)7".
template <std::size_t kSize>
constexpr bool is_number(const std::array<char, kSize>& name) {
  return name[0] >= '0' && name[0] <= '9';
}

/// The names of an enumeration's values, which count from 0.
template <class Enum, std::uint32_t... kValue>
constexpr auto enumerators_of() {
  constexpr Enum kNext{sizeof...(kValue)};
  if constexpr (!is_number(kNameInSource<kNext>)) {
    return enumerators_of<Enum, kValue..., sizeof...(kValue)>();
  } else {
    return std::array{kNameInSource<Enum{kValue}>.data()...};
  }
}
template <class Enum>
inline constexpr auto kEnumerators = enumerators_of<Enum>();

/// A member of a struct, by its name.
template <auto kMember>
struct Field;
template <class Struct, class Member, Member Struct::*kMember>
struct Field<kMember> {
  using Value = Member;
  static constexpr const char* kName = kMemberName<kMember>.data();
  static constexpr auto kPointer = kMember;
  static constexpr ValueRange kRange = kRangeOf<kMember>;
  static constexpr const char* kHelp = kHelpOf<kMember>;
  static constexpr bool kMayDiffer = kMayDifferBetweenRanks<kMember>;

  template <class Object>
  static constexpr auto& of(Object& object) {
    return object.*kMember;
  }
};

/// A field of a struct that is the member of another one.
template <auto kOuter, class Inner>
struct NestedField : Inner {
  template <class Object>
  static constexpr auto& of(Object& object) {
    return Inner::of(object.*kOuter);
  }
};

/// The field of one member, or the fields within it.
template <auto kMember>
constexpr auto fields_of_member() {
  using Value = typename Field<kMember>::Value;
  if constexpr (kIsFlattened<Value>) {
    return std::apply([]<class... Inner>(Inner... /*field*/) { return std::tuple<NestedField<kMember, Inner>...>(); },
                      kFields<Value>);
  } else {
    return std::tuple<Field<kMember>>();
  }
}

/// Converts to the type of any member.
struct AnyMember {
  template <class Member>
  operator Member() const;  // NOLINT(google-explicit-constructor)
};

/// Returns whether braces with so many values initialize the struct.
template <class Struct, class... Members>
constexpr bool takes_members(Members... members) {
  return requires {
    Struct{members...};
  };
}

/// The fields of a struct. Does not compile unless all its members are named.
template <class Struct, auto... kMembers>
constexpr auto fields_of() {
  constexpr auto kAny = [](auto /*member*/) { return AnyMember(); };
  static_assert(takes_members<Struct>(kAny(kMembers)...) && !takes_members<Struct>(kAny(kMembers)..., AnyMember()),
                "every member is named once");
  return std::tuple_cat(fields_of_member<kMembers>()...);
}

/// Calls visit(field) for each field of the struct.
template <class Struct, class Visit>
constexpr void for_each_field(const Visit& visit) {
  std::apply([&](auto... field) { (visit(field), ...); }, kFields<Struct>);
}

template <class Struct>
bool has_equal_fields(const Struct& a, const Struct& b) {
  return std::apply([&](auto... field) { return ((field.of(a) == field.of(b)) && ...); }, kFields<Struct>);
}

/// Returns the problem with a field's value: "cell_size_factor is 1000, but must be 0, or 0.1 to 100", or "detection is
/// 7, which is none of its values; they count from 0 to 1". Empty where nothing is wrong.
template <class AnyField, class Value>
std::string problem_of_value(AnyField field, const Value& value) {
  std::ostringstream problem;
  if constexpr (std::is_enum_v<Value>) {
    const auto number = static_cast<std::uint32_t>(value);
    const std::size_t last = kEnumerators<Value>.size() - 1;
    if (number > last) {
      problem << field.kName << " is " << number << ", which is none of its values; they count from 0 to " << last;
    }
  } else if constexpr (std::is_arithmetic_v<Value>) {
    const auto [least, most, or_zero] = field.kRange;
    const auto number = static_cast<double>(value);
    if ((number >= least && number <= most) || (or_zero && number == 0)) return {};
    problem << field.kName << " is " << value << ", but must be ";
    if (most < ValueRange().most) {
      problem << (or_zero ? "0, or " : "") << least << " to " << most;
    } else {
      problem << (std::is_integral_v<Value> ? "" : "finite and ") << "at least " << least;
    }
  }
  return problem.str();
}

/// Returns the problem with the first value that is not allowed. Empty where nothing is wrong.
template <class Struct>
std::string problem_of(const Struct& object) {
  std::string problem;
  for_each_field<Struct>([&](auto field) {
    if (problem.empty()) problem = problem_of_value(field, field.of(object));
  });
  return problem;
}

}  // namespace softcd
