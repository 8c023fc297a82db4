#ifndef SOFTCD_SOFTCD_PROBE_H
#define SOFTCD_SOFTCD_PROBE_H

/**
 * The part of softcd.h about probes, which includes it: what of a scene's bodies is at a place, how far bodies are from
 * each other, and what intersects.
 */

#include "softcd/softcd.h"

/* NOLINTBEGIN(modernize-*, readability-identifier-naming): as in softcd.h. */

#ifdef __cplusplus
extern "C" {
#endif

/** Asks what of a scene's bodies is at a place, in batches: questions in, as many answers out, in their order.
 *  Kinematic bodies answer too; groups, masks and margins do not count. Bodies whose positions were never set are left
 *  out, and so are triangles with a vertex that is not finite. Every call reads positions that were set and waits for a
 *  detection that runs. Answers are in the probe's memory: valid until its next call, until it is destroyed, or the
 *  scene's options are set. Questions may be NULL where there are none. */
typedef struct softcd_probe softcd_probe;

/** Asks about the end `step_end` of the step. */
SOFTCD_EXPORT softcd_status softcd_probe_create(softcd_scene* scene, softcd_step_end step_end, softcd_probe** probe);
/** NULL is nothing to destroy. */
SOFTCD_EXPORT void softcd_probe_destroy(softcd_probe* probe);

/** Called for every body that has positions, in ascending order; 0 leaves it out of the questions that are asked.
 * Called on the thread that asks. It must not call the scene, its queries or probes, and must return: no exception, no
 *  longjmp. */
typedef uint32_t (*softcd_body_filter)(void* user_data, softcd_body body);

/** Asked by every call from the next one on. NULL, as at first, leaves nobody out. */
SOFTCD_EXPORT softcd_status softcd_probe_set_body_filter(softcd_probe* probe, softcd_body_filter filter,
                                                         void* user_data);

/** The points origin + t direction, t_min <= t <= t_max. t counts in directions, whose length is any but 0. */
typedef struct softcd_ray {
  double origin[3];    /**< in world coordinates */
  double direction[3]; /**< the unit of t */
  double t_min;        /**< where the ray begins */
  double t_max;        /**< INFINITY for no end */
} softcd_ray;

/** Where a ray meets a triangle. */
typedef struct softcd_ray_hit {
  softcd_body body;  /**< SOFTCD_NO_BODY where the ray hits nothing */
  uint32_t triangle; /**< of the body; UINT32_MAX where the ray hits nothing */
  double t;          /**< the point is origin + t direction; INFINITY where the ray hits nothing */
  float weights[3];  /**< of the triangle's vertices there; their sum is 1 */
  float normal[3];   /**< unit vector along (x1 - x0) x (x2 - x0); 0 for a triangle without area */
} softcd_ray_hit;

/** For each of `count` rays what it meets first. */
SOFTCD_EXPORT softcd_status softcd_probe_first_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                                    const softcd_ray_hit** hits);
/** For each of `count` rays all triangles that it meets, in the order of t: ray i has hits[begins[i]] up to, but
 *  without, hits[begins[i + 1]]. There are count + 1 begins, and none where there are no rays. */
SOFTCD_EXPORT softcd_status softcd_probe_all_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                                  const uint64_t** begins, const softcd_ray_hit** hits);

/** A point that is asked for what is nearest to it, and at most max_distance away: INFINITY for any distance. */
typedef struct softcd_point {
  double point[3];     /**< in world coordinates */
  double max_distance; /**< at least 0; in the positions' unit */
} softcd_point;

/** The nearest point of a scene's triangles. */
typedef struct softcd_closest_point {
  softcd_body body;   /**< SOFTCD_NO_BODY where there is nothing within max_distance */
  uint32_t triangle;  /**< of the body; UINT32_MAX where there is nothing */
  double position[3]; /**< in world coordinates */
  double distance;    /**< at least 0; INFINITY where there is nothing within max_distance */
  float weights[3];   /**< of the triangle's vertices there; their sum is 1 */
  /** Where the body's surface is closed 1 on the side that normals point to, -1 on the other, 0 on it; else 0. */
  int32_t side;
} softcd_closest_point;

/** For each of `count` points the nearest of all triangles' points. */
SOFTCD_EXPORT softcd_status softcd_probe_closest_points(softcd_probe* probe, const softcd_point* points, uint64_t count,
                                                        const softcd_closest_point** closest);

/** All points at most `radius` from the centre. */
typedef struct softcd_sphere {
  double centre[3]; /**< in world coordinates */
  double radius;    /**< at least 0; in the positions' unit */
} softcd_sphere;

/** All points at most `radius` from the segment between two points; a ball where these are equal. */
typedef struct softcd_capsule {
  double from[3]; /**< one end of the segment, in world coordinates */
  double to[3];   /**< the other one */
  double radius;  /**< at least 0; in the positions' unit */
} softcd_capsule;

/** All points between lo and hi. */
typedef struct softcd_box {
  double lo[3]; /**< its lowest coordinates */
  double hi[3]; /**< its highest coordinates */
} softcd_box;

/** All points centre + x axes[0] + y axes[1] + z axes[2], |x| <= half[0] and so on; the axes are unit vectors at right
 *  angles to each other. */
typedef struct softcd_oriented_box {
  double centre[3];  /**< in world coordinates */
  double half[3];    /**< half its extent along each axis, at least 0 */
  double axes[3][3]; /**< one behind the other */
} softcd_oriented_box;

/** All points at most `radius` from the convex hull of some points: a polyhedron, a piece of a plane or a line, a ball
 *  around one point. In any order; nothing where there is no point. */
typedef struct softcd_hull {
  const double* points; /**< 3 * point_count world coordinates, read during the call; NULL where there are none */
  uint64_t point_count; /**< how many points */
  double radius;        /**< at least 0; in the positions' unit */
} softcd_hull;

/** A triangle that has a point in common with a shape. */
typedef struct softcd_overlap {
  softcd_body body;  /**< the one that the triangle is of */
  uint32_t triangle; /**< of the body */
} softcd_overlap;

/** For each of `count` spheres all triangles that have a point in common with it, borders included, in the order of
 *  bodies and indices; in lists as those of softcd_probe_all_hits(). */
SOFTCD_EXPORT softcd_status softcd_probe_sphere_overlaps(softcd_probe* probe, const softcd_sphere* spheres,
                                                         uint64_t count, const uint64_t** begins,
                                                         const softcd_overlap** overlaps);
/** The same for capsules. */
SOFTCD_EXPORT softcd_status softcd_probe_capsule_overlaps(softcd_probe* probe, const softcd_capsule* capsules,
                                                          uint64_t count, const uint64_t** begins,
                                                          const softcd_overlap** overlaps);
/** The same for boxes. */
SOFTCD_EXPORT softcd_status softcd_probe_box_overlaps(softcd_probe* probe, const softcd_box* boxes, uint64_t count,
                                                      const uint64_t** begins, const softcd_overlap** overlaps);
/** The same for boxes that are turned. */
SOFTCD_EXPORT softcd_status softcd_probe_oriented_box_overlaps(softcd_probe* probe, const softcd_oriented_box* boxes,
                                                               uint64_t count, const uint64_t** begins,
                                                               const softcd_overlap** overlaps);
/** The same for convex hulls, told unless a plane parts them; for slivers, triangles or hulls, one that is told may be
 *  apart by somewhat more than rounding. SOFTCD_INVALID_INPUT where all together have 2^31 points or more. */
SOFTCD_EXPORT softcd_status softcd_probe_hull_overlaps(softcd_probe* probe, const softcd_hull* hulls, uint64_t count,
                                                       const uint64_t** begins, const softcd_overlap** overlaps);

/** The nearest points of two bodies' triangles. */
typedef struct softcd_body_distance {
  softcd_body body_a;   /**< SOFTCD_NO_BODY where there is nothing to compare */
  softcd_body body_b;   /**< another one */
  uint32_t triangle_a;  /**< of body_a; UINT32_MAX where there is nothing */
  uint32_t triangle_b;  /**< of body_b */
  double position_a[3]; /**< the point of triangle_a, in world coordinates */
  double position_b[3]; /**< the point of triangle_b */
  double distance;      /**< at least 0; exactly 0 where the triangles intersect; INFINITY for nothing */
  float weights_a[3];   /**< of triangle_a's vertices at the point; their sum is 1 */
  float weights_b[3];   /**< of triangle_b's */
} softcd_body_distance;

/** For each of `count` pairs of bodies the nearest points of a triangle of a and a triangle of b, which are different
 *  bodies. SOFTCD_NO_BODY in a pair stands for all: {a, SOFTCD_NO_BODY} is a with each other body. Takes time for each
 *  triangle of a: the smaller body goes first. This and the next two are SOFTCD_INVALID_INPUT where a body is not
 *  there. */
SOFTCD_EXPORT softcd_status softcd_probe_distances(softcd_probe* probe, const softcd_body_pair* pairs, uint64_t count,
                                                   const softcd_body_distance** distances);

/** Two triangles that intersect: of different bodies where they have a point in common, borders included; of one body
 *  where a side of one and the other triangle do that have no vertex in common. */
typedef struct softcd_intersection {
  softcd_body body_a;  /**< that of the first triangle */
  uint32_t triangle_a; /**< of body_a */
  softcd_body body_b;  /**< that of the second one, which may be the same */
  uint32_t triangle_b; /**< of body_b */
} softcd_intersection;

/** For each of `count` pairs of bodies all triangles of a and b that intersect, decided exactly for the positions that
 *  the scene has; within a body where a is b, and of all bodies with each other and with themselves where both are
 *  SOFTCD_NO_BODY. Each two once, in the order of bodies and indices of the first, then of the second; in lists like
 *  those of softcd_probe_all_hits(). */
SOFTCD_EXPORT softcd_status softcd_probe_intersections(softcd_probe* probe, const softcd_body_pair* pairs,
                                                       uint64_t count, const uint64_t** begins,
                                                       const softcd_intersection** intersections);
/** Whether there is one: `has_intersections` is 1, else 0. NULL for `pair` is the whole scene. */
SOFTCD_EXPORT softcd_status softcd_probe_has_intersections(softcd_probe* probe, const softcd_body_pair* pair,
                                                           uint32_t* has_intersections);

/** A change of one body's mesh that might be made: an edge split, collapsed or flipped, a hole filled. An array may be
 *  NULL where its count is 0. */
typedef struct softcd_change {
  softcd_body body;        /**< whose mesh it is */
  const uint32_t* removed; /**< triangles of the body that would not be there any more */
  uint64_t removed_count;  /**< how many */
  const uint32_t* added;   /**< what would come instead: 3 * added_count indices of vertices */
  uint64_t added_count;    /**< how many triangles */
  /** 3 * new_vertex_count world coordinates. New vertex i has the index `vertex_count of the body + i`; a vertex that
   *  would move is a new one. */
  const double* new_vertices;
  uint64_t new_vertex_count; /**< how many vertices */
} softcd_change;

/** A triangle that a change would add, and what it would intersect. */
typedef struct softcd_change_intersection {
  uint32_t added;    /**< index in softcd_change::added, in triangles */
  softcd_body body;  /**< what the other one is of; SOFTCD_NO_BODY where it would be added, too */
  uint32_t triangle; /**< of the body as it is, or a higher index in softcd_change::added */
} softcd_change_intersection;

/** For each of `count` changes what its new triangles would intersect, as softcd_probe_intersections() decides: all
 *  triangles that would stay, of all bodies, and each other. Changes are judged one by one, with the scene as it is. In
 *  the order of the added triangles, then of the others' bodies and indices, those of the same change last; in lists as
 *  those of softcd_probe_all_hits(). SOFTCD_INVALID_INPUT, with a text that names the change, where something of it is
 *  out of range, or not finite, or the body has no positions. */
SOFTCD_EXPORT softcd_status softcd_probe_intersections_after(softcd_probe* probe, const softcd_change* changes,
                                                             uint64_t count, const uint64_t** begins,
                                                             const softcd_change_intersection** intersections);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* NOLINTEND(modernize-*, readability-identifier-naming) */

#endif /* SOFTCD_SOFTCD_PROBE_H */
