#ifndef SOFTCD_C_CLIENT_H
#define SOFTCD_C_CLIENT_H

/* A user of softcd.h in C, for tests in C++. */

/* NOLINTBEGIN(modernize-*, readability-identifier-naming): as in softcd.h. */

#include <softcd/softcd.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct client_body {
  const uint32_t* triangles;
  uint64_t triangle_count;
  uint32_t vertex_count;
  softcd_body_settings settings;
  softcd_positions x_t0, x_t1;
} client_body;

/** Detects with start and wait, and with detect. Writes up to `capacity` contacts, whose number is *count, unless the
 *  two differ: SOFTCD_ERROR. */
softcd_status client_detect(const client_body* bodies, size_t body_count, const softcd_scene_options* scene_options,
                            const softcd_query_options* query_options, softcd_contact* contacts, uint64_t capacity,
                            uint64_t* count);

/** X(struct) for each struct that softcd.h defines. */
#define SOFTCD_CLIENT_STRUCTS(X) \
  X(softcd_scene_options)        \
  X(softcd_body_settings)        \
  X(softcd_mesh)                 \
  X(softcd_positions)            \
  X(softcd_body_pair)            \
  X(softcd_vertex_filter)        \
  X(softcd_query_options)        \
  X(softcd_contact)              \
  X(softcd_device_contacts)      \
  X(softcd_contact_counts)       \
  X(softcd_pending_contacts)     \
  X(softcd_statistics)           \
  X(softcd_ray)                  \
  X(softcd_ray_hit)              \
  X(softcd_point)                \
  X(softcd_closest_point)        \
  X(softcd_sphere)               \
  X(softcd_capsule)              \
  X(softcd_box)                  \
  X(softcd_oriented_box)         \
  X(softcd_hull)                 \
  X(softcd_overlap)              \
  X(softcd_body_distance)        \
  X(softcd_intersection)         \
  X(softcd_curve_point)          \
  X(softcd_intersection_curve)   \
  X(softcd_region_vertex)        \
  X(softcd_intersection_region)  \
  X(softcd_intersection_regions) \
  X(softcd_change)               \
  X(softcd_change_intersection)

/** sizeof of each struct as C has it, in the order of SOFTCD_CLIENT_STRUCTS. Returns how many. */
size_t client_struct_sizes(size_t* sizes, size_t capacity);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*, readability-identifier-naming) */

#endif
