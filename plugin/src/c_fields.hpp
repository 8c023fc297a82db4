#pragma once

#include "c_interface.hpp"
#include "softcd/fields/options.hpp"

/// The structs of softcd.h that stand for structs of softcd.hpp. Members of one name have one meaning.
namespace softcd {

template <>
inline constexpr auto kFields<softcd_scene_options> =
    fields_of<softcd_scene_options, &softcd_scene_options::struct_size, &softcd_scene_options::backend,
              &softcd_scene_options::memory_limit, &softcd_scene_options::max_threads,
              &softcd_scene_options::cuda_device, &softcd_scene_options::cuda_stream>();

template <>
inline constexpr auto kFields<softcd_body_settings> = fields_of<
    softcd_body_settings, &softcd_body_settings::struct_size, &softcd_body_settings::margin,
    &softcd_body_settings::filter_group, &softcd_body_settings::filter_mask, &softcd_body_settings::self_collision,
    &softcd_body_settings::kinematic, &softcd_body_settings::vertex_triangle, &softcd_body_settings::edge_edge,
    &softcd_body_settings::batch, &softcd_body_settings::neighbour_rings, &softcd_body_settings::rest_distance>();

template <>
inline constexpr auto kFields<softcd_query_options> = fields_of<
    softcd_query_options, &softcd_query_options::struct_size, &softcd_query_options::detection,
    &softcd_query_options::accuracy, &softcd_query_options::broad_phase, &softcd_query_options::contact_rule,
    &softcd_query_options::step_end, &softcd_query_options::subdivision, &softcd_query_options::lambda,
    &softcd_query_options::motion_margin, &softcd_query_options::margins, &softcd_query_options::vertex_triangle,
    &softcd_query_options::edge_edge, &softcd_query_options::reuse_pairs, &softcd_query_options::contacts_on_device,
    &softcd_query_options::neighbour_filters>();

template <>
inline constexpr auto kFields<softcd_statistics> =
    fields_of<softcd_statistics, &softcd_statistics::struct_size, &softcd_statistics::backend,
              &softcd_statistics::bodies, &softcd_statistics::triangles, &softcd_statistics::vertices,
              &softcd_statistics::edges, &softcd_statistics::active_triangles, &softcd_statistics::left_out_triangles,
              &softcd_statistics::triangle_pairs, &softcd_statistics::vt_candidates, &softcd_statistics::ee_candidates,
              &softcd_statistics::vt_contacts, &softcd_statistics::ee_contacts, &softcd_statistics::unsettled_contacts,
              &softcd_statistics::earliest_toi, &softcd_statistics::peak_bytes, &softcd_statistics::reruns,
              &softcd_statistics::chunks, &softcd_statistics::total_ms>();

namespace c_interface {

/// Calls visit(c_field, field) for the members of equal names. Returns how many there are.
template <class C, class Struct, class Visit>
constexpr std::size_t for_each_pair(const Visit& visit) {
  std::size_t pairs = 0;
  const auto visit_one = [&]<std::size_t kIndex>(std::integral_constant<std::size_t, kIndex> /*member*/) {
    constexpr auto kInC = std::get<kIndex>(kFields<C>);
    constexpr std::size_t kPlace = index_of_field<Struct>(kInC.name);
    if constexpr (kPlace < kFieldCount<Struct>) {
      visit(kInC, std::get<kPlace>(kFields<Struct>));
      ++pairs;
    }
  };
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (visit_one(std::integral_constant<std::size_t, kIndex>()), ...);
  }
  (std::make_index_sequence<kFieldCount<C>>());
  return pairs;
}

/// Whether all members have a counterpart, but for so many of the C struct's, struct_size among them, and of the
/// other's.
template <class C, class Struct>
constexpr bool correspond(std::size_t alone_in_c, std::size_t alone_in_cpp) {
  const std::size_t pairs = for_each_pair<C, Struct>([](const auto&...) {});
  return pairs + alone_in_c == kFieldCount<C> && pairs + alone_in_cpp == kFieldCount<Struct>;
}
static_assert(correspond<softcd_scene_options, SceneOptions>(1, 1), "all but `communicator`");
static_assert(correspond<softcd_body_settings, BodySettings>(1, 0));
static_assert(correspond<softcd_query_options, QueryOptions>(1, 0));
static_assert(correspond<softcd_statistics, Statistics>(2, 11), "total_ms is ms.total; C has no counts of the grid");

template <class C, class Struct>
C to_c(const Struct& from) {
  C to{};
  to.struct_size = sizeof(C);
  for_each_pair<C, Struct>([&](const auto& c_field, const auto& field) {
    auto& value = c_field.of(to);
    value = static_cast<std::remove_reference_t<decltype(value)>>(field.of(from));
  });
  return to;
}

/// The defaults where nothing is given.
template <class Struct, class C>
Struct from_c(const C* given, const char* argument) {
  Struct to;
  if (given == nullptr) return to;
  const C& from = sized(given, argument);
  for_each_pair<C, Struct>([&](const auto& c_field, const auto& field) {
    auto& value = field.of(to);
    value = static_cast<std::remove_reference_t<decltype(value)>>(c_field.of(from));
  });
  return to;
}

}  // namespace c_interface
}  // namespace softcd
