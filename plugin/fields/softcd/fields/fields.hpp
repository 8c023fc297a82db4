#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

/// Members of structs by name. All that handles options one by one is derived from such a list: equality, checks, the
/// comparison between ranks, C, Python, PyBullet and command lines.
namespace softcd {

/// The fields of a struct, a tuple made by fields_of(): specialized for every struct that has such a list.
template <class Struct>
inline constexpr auto kFields = nullptr;

/// The allowed values of a number. Infinity and NaN are never allowed.
struct ValueRange {
  double least = std::numeric_limits<double>::lowest();
  double most = std::numeric_limits<double>::max();
  bool or_zero = false;  ///< 0 is allowed, too

  constexpr bool has(double value) const { return (value >= least && value <= most) || (or_zero && value == 0); }
};

/// The allowed values of a member: specialized for those with a limit.
template <auto kMember>
inline constexpr ValueRange kRangeOf = {};

/// Whether ranks of a Communicator may have different values: specialized for members that change no contacts.
template <auto kMember>
inline constexpr bool kMayDifferBetweenRanks = false;

/// Whether the fields of a member of this type count as fields of the struct that it is in.
template <class Member>
inline constexpr bool kIsFlattened = false;

/// A member of a struct. `access` is a pointer to it, or a function that returns a reference to it.
template <class Access>
struct Field {
  const char* name;
  Access access;
  ValueRange range = {};
  bool may_differ_between_ranks = false;

  template <class Struct>
  constexpr auto& of(Struct& object) const {
    return std::invoke(access, object);
  }
};
template <class Access, class... Rest>
Field(const char*, Access, Rest...) -> Field<Access>;

template <class Struct, class Access>
using FieldValue = std::remove_cvref_t<std::invoke_result_t<const Access&, Struct&>>;

/// What the compiler calls a member or an enumerator: the end of this function's name, "... = &Struct::member]".
template <auto kConstant>
constexpr auto name_in_source() {
  constexpr std::string_view kFunction = __PRETTY_FUNCTION__;
  constexpr std::size_t kBegin = kFunction.rfind(':') + 1;
  std::array<char, kFunction.size() - kBegin> name{};
  for (std::size_t i = 0; i + 1 < name.size(); ++i) name[i] = kFunction[kBegin + i];
  return name;
}
template <auto kConstant>
inline constexpr auto kNameInSource = name_in_source<kConstant>();

/// The names of an enumeration's values, which count from 0. A number without a name is printed as a cast, "(Enum)7".
template <class Enum, std::uint32_t kCount = 0>
constexpr auto enumerators_of() {
  if constexpr (std::string_view(kNameInSource<Enum{kCount}>.data()).find(')') == std::string_view::npos) {
    return enumerators_of<Enum, kCount + 1>();
  } else {
    return []<std::uint32_t... kValue>(std::integer_sequence<std::uint32_t, kValue...> /*values*/) {
      return std::array{kNameInSource<Enum{kValue}>.data()...};
    }
    (std::make_integer_sequence<std::uint32_t, kCount>());
  }
}
template <class Enum>
inline constexpr auto kEnumerators = enumerators_of<Enum>();

/// Reaches a member of a member.
template <class Outer, class Inner>
struct Nested {
  Outer outer;
  Inner inner;

  template <class Struct>
  constexpr auto& operator()(Struct& object) const {
    return std::invoke(inner, std::invoke(outer, object));
  }
};

/// The field of one member, or the fields within it.
template <auto kMember, class Struct, class Member>
constexpr auto fields_of_member(Member Struct::*member) {
  if constexpr (kIsFlattened<Member>) {
    const auto nested = [member](const auto& field) {
      const Nested<decltype(member), decltype(field.access)> access{member, field.access};
      return Field{field.name, access, field.range, field.may_differ_between_ranks};
    };
    return std::apply([&](const auto&... field) { return std::tuple(nested(field)...); }, kFields<Member>);
  } else {
    return std::tuple(Field{kNameInSource<kMember>.data(), member, kRangeOf<kMember>, kMayDifferBetweenRanks<kMember>});
  }
}

/// Converts to the type of any member.
struct AnyMember {
  template <class Member>
  operator Member() const;  // NOLINT(google-explicit-constructor)
};

/// Whether braces with so many values initialize the struct.
template <class Struct, std::size_t... kIndex>
constexpr bool takes_members(std::index_sequence<kIndex...> /*members*/) {
  return requires {
    Struct{(static_cast<void>(kIndex), AnyMember())...};
  };
}

/// The fields of a struct. Does not compile unless all its members are named.
template <class Struct, auto... kMembers>
constexpr auto fields_of() {
  static_assert(takes_members<Struct>(std::make_index_sequence<sizeof...(kMembers)>()) &&
                    !takes_members<Struct>(std::make_index_sequence<sizeof...(kMembers) + 1>()),
                "every member is named once");
  return std::tuple_cat(fields_of_member<kMembers>(kMembers)...);
}

/// Calls visit(field) for each field of the struct.
template <class Struct, class Visit>
constexpr void for_each_field(const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, kFields<Struct>);
}

template <class Struct>
inline constexpr std::size_t kFieldCount = std::tuple_size_v<std::remove_cvref_t<decltype(kFields<Struct>)>>;

/// The number of the field with this name; kFieldCount where there is none.
template <class Struct>
constexpr std::size_t index_of_field(std::string_view name) {
  std::size_t index = 0;
  std::size_t found = kFieldCount<Struct>;
  for_each_field<Struct>([&](const auto& field) {
    if (name == field.name) found = index;
    ++index;
  });
  return found;
}

template <class Struct>
bool has_equal_fields(const Struct& a, const Struct& b) {
  return std::apply([&](const auto&... field) { return ((field.of(a) == field.of(b)) && ...); }, kFields<Struct>);
}

/// The shortest digits that give the same number.
template <class Number>
std::string digits_of(Number number) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

inline std::string text_of(const ValueRange& range, bool is_integer) {
  const bool has_most = range.most < std::numeric_limits<double>::max();
  if (!has_most) return (is_integer ? "at least " : "finite and at least ") + digits_of(range.least);
  return (range.or_zero ? "0, or " : "") + digits_of(range.least) + " to " + digits_of(range.most);
}

/// What is wrong with a field's value, "lambda is 1000, but must be 0, or 0.1 to 100"; empty where nothing is.
template <class Access, class Value>
std::string problem_of(const Field<Access>& field, const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    const auto number = static_cast<std::underlying_type_t<Value>>(value);
    if (number < kEnumerators<Value>.size()) return {};
    return std::string(field.name) + " is " + digits_of(number) +
           ", which is none of its values; they count from 0 to " + digits_of(kEnumerators<Value>.size() - 1);
  } else if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
    if (field.range.has(static_cast<double>(value))) return {};
    return std::string(field.name) + " is " + digits_of(value) + ", but must be " +
           text_of(field.range, std::is_integral_v<Value>);
  } else {
    return {};
  }
}

/// What is wrong with the first value that is not allowed; empty where nothing is.
template <class Struct>
std::string problem_of(const Struct& object) {
  std::string problem;
  for_each_field<Struct>([&](const auto& field) {
    if (problem.empty()) problem = problem_of(field, field.of(object));
  });
  return problem;
}

}  // namespace softcd
