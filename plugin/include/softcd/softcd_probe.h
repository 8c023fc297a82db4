#ifndef SOFTCD_SOFTCD_PROBE_H
#define SOFTCD_SOFTCD_PROBE_H

/**
 * The part of softcd.h about probes; softcd.h includes it. Probes find triangles at a place, distances between bodies,
 * and intersections.
 */

#include "softcd/softcd.h"

/* NOLINTBEGIN(modernize-*, readability-identifier-naming): as in softcd.h. */

#ifdef __cplusplus
extern "C" {
#endif

/** Answers spatial questions about a scene's bodies, in batches: one result or one list for each question, in the same
 *  order. Kinematic bodies count too; groups, masks and margins do not. Bodies whose positions were never set are left
 *  out, and so are triangles with a vertex that is not finite. Every call reads positions that were set, and waits for
 *  a running detection. Results are in the probe's memory. They stay valid until its next call, until it is destroyed,
 *  or until the scene's options are set. The array of questions may be NULL where there are none. */
typedef struct softcd_probe softcd_probe;

/** Makes a probe that uses the positions at the end `step_end` of the step. */
SOFTCD_EXPORT softcd_status softcd_probe_create(softcd_scene* scene, softcd_step_end step_end, softcd_probe** probe);
/** Destroys the probe. NULL is allowed. */
SOFTCD_EXPORT void softcd_probe_destroy(softcd_probe* probe);

/** Decides which bodies a probe sees; 0 excludes the body. Called on the thread that calls the probe, in ascending
 *  order, for every body that has positions. It must not call the scene, its queries or probes, and must return: no
 *  exception, no longjmp. */
typedef uint32_t (*softcd_body_filter)(void* user_data, softcd_body body);

/** Sets the filter that every later call asks. NULL, the default, excludes no body. */
SOFTCD_EXPORT softcd_status softcd_probe_set_body_filter(softcd_probe* probe, softcd_body_filter filter,
                                                         void* user_data);

/** The points origin + t direction, t_min <= t <= t_max. The direction may have any length but 0; t is in units of
 *  it. */
typedef struct softcd_ray {
  double origin[3];    /**< in world coordinates */
  double direction[3]; /**< the unit of t */
  double t_min;        /**< where the ray begins */
  double t_max;        /**< INFINITY for no end */
} softcd_ray;

/** The point at which a ray meets a triangle. */
typedef struct softcd_ray_hit {
  softcd_body body;  /**< SOFTCD_NO_BODY where the ray hits nothing */
  uint32_t triangle; /**< index in the body; UINT32_MAX where the ray hits nothing */
  double t;          /**< the point is origin + t direction; INFINITY where the ray hits nothing */
  float weights[3];  /**< the point's weights on the triangle's vertices; their sum is 1 */
  float normal[3];   /**< unit vector along (x1 - x0) x (x2 - x0); 0 for a triangle without area */
} softcd_ray_hit;

/** Finds the first triangle that each of `count` rays meets. */
SOFTCD_EXPORT softcd_status softcd_probe_first_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                                    const softcd_ray_hit** hits);
/** Finds all triangles that each of `count` rays meets, in the order of t. Ray i has hits[begins[i]] up to, but
 *  without, hits[begins[i + 1]]. There are count + 1 begins, and none where there are no rays. */
SOFTCD_EXPORT softcd_status softcd_probe_all_hits(softcd_probe* probe, const softcd_ray* rays, uint64_t count,
                                                  const uint64_t** begins, const softcd_ray_hit** hits);

/** A point for which a probe finds the nearest triangle within max_distance: INFINITY for any distance. */
typedef struct softcd_point {
  double point[3];     /**< in world coordinates */
  double max_distance; /**< at least 0; in the positions' unit */
} softcd_point;

/** The nearest point of a scene's triangles. */
typedef struct softcd_closest_point {
  softcd_body body;   /**< SOFTCD_NO_BODY where nothing is within max_distance */
  uint32_t triangle;  /**< index in the body; UINT32_MAX where there is nothing */
  double position[3]; /**< in world coordinates */
  double distance;    /**< at least 0; INFINITY where nothing is within max_distance */
  float weights[3];   /**< the point's weights on the triangle's vertices; their sum is 1 */
  /** Where the body's surface is closed 1 on the side that normals point to, -1 on the other, 0 on it; else 0. */
  int32_t side;
} softcd_closest_point;

/** Finds the nearest point of all triangles for each of `count` points. */
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
 *  around one point. The points may be in any order. Empty where there is no point. */
typedef struct softcd_hull {
  const double* points; /**< 3 * point_count world coordinates, read during the call; NULL where there are none */
  uint64_t point_count; /**< how many points */
  double radius;        /**< at least 0; in the positions' unit */
} softcd_hull;

/** A triangle that has a point in common with a shape. */
typedef struct softcd_overlap {
  softcd_body body;  /**< the triangle's body */
  uint32_t triangle; /**< index in the body */
} softcd_overlap;

/** Finds all triangles that have a point in common with each of `count` spheres, borders included, in the order of
 *  bodies and indices. The lists are as those of softcd_probe_all_hits(). */
SOFTCD_EXPORT softcd_status softcd_probe_sphere_overlaps(softcd_probe* probe, const softcd_sphere* spheres,
                                                         uint64_t count, const uint64_t** begins,
                                                         const softcd_overlap** overlaps);
/** Finds all triangles that overlap each capsule, as for spheres. */
SOFTCD_EXPORT softcd_status softcd_probe_capsule_overlaps(softcd_probe* probe, const softcd_capsule* capsules,
                                                          uint64_t count, const uint64_t** begins,
                                                          const softcd_overlap** overlaps);
/** Finds all triangles that overlap each box, as for spheres. */
SOFTCD_EXPORT softcd_status softcd_probe_box_overlaps(softcd_probe* probe, const softcd_box* boxes, uint64_t count,
                                                      const uint64_t** begins, const softcd_overlap** overlaps);
/** Finds all triangles that overlap each oriented box, as for spheres. */
SOFTCD_EXPORT softcd_status softcd_probe_oriented_box_overlaps(softcd_probe* probe, const softcd_oriented_box* boxes,
                                                               uint64_t count, const uint64_t** begins,
                                                               const softcd_overlap** overlaps);
/** Finds all triangles that overlap each convex hull, as for spheres: those that no plane separates from it. For sliver
 *  triangles or hulls, a reported triangle may be apart by somewhat more than rounding. Returns SOFTCD_INVALID_INPUT
 *  where all hulls together have 2^31 points or more. */
SOFTCD_EXPORT softcd_status softcd_probe_hull_overlaps(softcd_probe* probe, const softcd_hull* hulls, uint64_t count,
                                                       const uint64_t** begins, const softcd_overlap** overlaps);

/** The nearest points of two bodies' triangles. */
typedef struct softcd_body_distance {
  softcd_body body_a;   /**< SOFTCD_NO_BODY where there is nothing to compare */
  softcd_body body_b;   /**< another body */
  uint32_t triangle_a;  /**< index in body_a; UINT32_MAX where there is nothing */
  uint32_t triangle_b;  /**< index in body_b */
  double position_a[3]; /**< the point of triangle_a, in world coordinates */
  double position_b[3]; /**< the point of triangle_b */
  double distance;      /**< at least 0; exactly 0 where the triangles intersect; INFINITY for nothing */
  float weights_a[3];   /**< of triangle_a's vertices at the point; their sum is 1 */
  float weights_b[3];   /**< the same for triangle_b */
} softcd_body_distance;

/** Finds the nearest points of a triangle of a and a triangle of b for each of `count` pairs of different bodies.
 *  SOFTCD_NO_BODY in a pair stands for all: {a, SOFTCD_NO_BODY} is a with each other body. Takes time for each triangle
 *  of a, so the smaller body should be a. This and the next two functions return SOFTCD_INVALID_INPUT where a body is
 *  not in the scene. */
SOFTCD_EXPORT softcd_status softcd_probe_distances(softcd_probe* probe, const softcd_body_pair* pairs, uint64_t count,
                                                   const softcd_body_distance** distances);

/** Two triangles that intersect. In different bodies, they have a point in common, borders included. In one body, a
 *  side of one triangle meets the other triangle, and that side has no vertex of the other triangle. */
typedef struct softcd_intersection {
  softcd_body body_a;  /**< the first triangle's body */
  uint32_t triangle_a; /**< index in body_a */
  softcd_body body_b;  /**< the second triangle's body, which may be the same */
  uint32_t triangle_b; /**< index in body_b */
} softcd_intersection;

/** Finds all intersecting triangles of each of `count` pairs of bodies. The decision is exact for the positions as
 * given, float or double. Where a is b, it finds intersections within the body. Where both are SOFTCD_NO_BODY, it
 * compares all bodies with each other and with themselves. Each intersection is reported once, in the order of bodies
 * and indices of the first triangle, then of the second. The lists are as those of softcd_probe_all_hits(). */
SOFTCD_EXPORT softcd_status softcd_probe_intersections(softcd_probe* probe, const softcd_body_pair* pairs,
                                                       uint64_t count, const uint64_t** begins,
                                                       const softcd_intersection** intersections);
/** Sets `has_intersections` to 1 where softcd_probe_intersections() would find one, else to 0. NULL for `pair` is the
 * whole scene. */
SOFTCD_EXPORT softcd_status softcd_probe_has_intersections(softcd_probe* probe, const softcd_body_pair* pair,
                                                           uint32_t* has_intersections);

/** The kinds of regions, by what bounds them: SOFTCD_REGION_CLOSED by closed curves, or whole inside a closed body;
 *  SOFTCD_REGION_LOOP_WITH_BORDER by curves and the surface's border; SOFTCD_REGION_OPEN by nothing: the curve does not
 *  separate the surface; SOFTCD_REGION_DEGENERATE by curves from which no side follows. */
typedef uint32_t softcd_region_kind;
enum {
  SOFTCD_REGION_CLOSED = 0,
  SOFTCD_REGION_LOOP_WITH_BORDER = 1,
  SOFTCD_REGION_OPEN = 2,
  SOFTCD_REGION_DEGENERATE = 3
};

/** A point of an intersection curve: an edge passes through a triangle. Both ends of the edge are one vertex where the
 *  curve ends at a vertex that two intersecting triangles share. */
typedef struct softcd_curve_point {
  double position[3];        /**< in world coordinates */
  softcd_body edge_body;     /**< the edge's body */
  uint32_t edge[2];          /**< vertices of edge_body, the lower one first */
  softcd_body triangle_body; /**< the triangle's body */
  uint32_t triangle;         /**< index in triangle_body */
  uint32_t unused;           /**< 0 */
} softcd_curve_point;

/** A curve along which two surfaces, or a surface and itself, intersect. */
typedef struct softcd_intersection_curve {
  softcd_body body_a;   /**< a body */
  softcd_body body_b;   /**< a body with the same or a higher id */
  uint32_t first_point; /**< index in softcd_intersection_regions::points */
  uint32_t point_count; /**< number of points, in the order of the curve */
  uint8_t is_closed;    /**< 1: the last point is followed by the first one */
  uint8_t is_perturbed; /**< 1: some of its points exist only because touching triangles were moved apart or together */
  uint8_t unused[6];    /**< 0 */
  double length;        /**< in the positions' unit */
} softcd_intersection_curve;

/** A vertex of a region, and the way out. */
typedef struct softcd_region_vertex {
  uint32_t vertex;     /**< index in the region's body */
  uint32_t unused;     /**< 0 */
  double direction[3]; /**< unit vector; 0 where none is known */
  double distance;     /**< to move along the direction, in the positions' unit */
} softcd_region_vertex;

/** A part of a body's surface on the wrong side of another body, or of itself. Where the other body's surface is
 *  closed, this is its inside; else of the two sides of curves the one with the smaller area. Its vertices lead to the
 *  nearest point of the other surface. For SOFTCD_REGION_OPEN and SOFTCD_REGION_DEGENERATE they shorten the curve. */
typedef struct softcd_intersection_region {
  softcd_body body;        /**< the body whose surface this is */
  softcd_body other;       /**< the body that it intersects; may be the same */
  softcd_region_kind kind; /**< what bounds it */
  uint8_t is_inside;       /**< 1: inside the closed surface of another body, decided exactly */
  uint8_t is_perturbed;    /**< 1: one of its curves is */
  uint8_t unused[2];       /**< 0 */
  uint32_t first_vertex;   /**< index in softcd_intersection_regions::vertices */
  uint32_t vertex_count;   /**< may be 0: the other surface then passes through triangles without reaching a vertex */
  uint32_t first_triangle; /**< index in softcd_intersection_regions::triangles */
  uint32_t triangle_count; /**< triangles with a vertex of the region, or along its curves */
  uint32_t first_curve;    /**< index in softcd_intersection_regions::region_curves */
  uint32_t curve_count;    /**< number of curves that bound it */
  double area;             /**< triangles count by their share of vertices in the region */
  double curve_length;     /**< of these curves together */
} softcd_intersection_region;

/** Arrays in the probe's memory; those of regions belong to one region behind the other. */
typedef struct softcd_intersection_regions {
  const softcd_intersection_region* regions; /**< by body, other body, lowest triangle */
  const softcd_region_vertex* vertices;      /**< of all regions */
  const uint32_t* triangles;                 /**< of all regions; indices in the region's body */
  const uint32_t* region_curves;             /**< of all regions; indices in `curves` */
  const softcd_intersection_curve* curves;   /**< all curves */
  const softcd_curve_point* points;          /**< of all curves */
  uint64_t region_count;                     /**< number of regions */
  uint64_t curve_count;                      /**< number of curves */
  uint64_t touching_pairs;                   /**< pairs of intersecting triangles that only touch */
} softcd_intersection_regions;

/** Finds the curves along which surfaces intersect, the regions of each surface that are on the wrong side, and the way
 *  out for their vertices, for the positions as given. `pair` is as for softcd_probe_intersections(); NULL is the
 *  whole scene. */
SOFTCD_EXPORT softcd_status softcd_probe_intersection_regions(softcd_probe* probe, const softcd_body_pair* pair,
                                                              softcd_intersection_regions* regions);

/** A possible change of one body's mesh: an edge split, collapsed or flipped, a hole filled. An array may be NULL where
 *  its count is 0. */
typedef struct softcd_change {
  softcd_body body;        /**< the body whose mesh would change */
  const uint32_t* removed; /**< indices of the triangles that the change removes */
  uint64_t removed_count;  /**< their number */
  const uint32_t* added;   /**< the triangles that it adds: 3 * added_count indices of vertices */
  uint64_t added_count;    /**< their number */
  /** 3 * new_vertex_count world coordinates. New vertex i has the index `vertex_count of the body + i`. A moved vertex
   *  counts as a new one. */
  const double* new_vertices;
  uint64_t new_vertex_count; /**< their number */
} softcd_change;

/** A triangle that a change would add, and a triangle that it would intersect. */
typedef struct softcd_change_intersection {
  uint32_t added;    /**< index in softcd_change::added, in triangles */
  softcd_body body;  /**< the other triangle's body; SOFTCD_NO_BODY where the change adds that one, too */
  uint32_t triangle; /**< index in that body as it is, or a higher index in softcd_change::added */
} softcd_change_intersection;

/** Finds, for each of `count` possible changes, the triangles that its new triangles would intersect, for positions
 *  rounded to float32. New triangles are compared with all remaining triangles of all bodies, and with each
 *  other. Each change is judged alone, with the scene as it is. Results are in the order of the added triangles, then
 *  of the other triangles' bodies and indices; triangles of the same change come last. The lists are as those of
 *  softcd_probe_all_hits(). Returns SOFTCD_INVALID_INPUT, with a text that names the change, where an index is out of
 *  range, a coordinate is not finite, or the body has no positions. */
SOFTCD_EXPORT softcd_status softcd_probe_intersections_after(softcd_probe* probe, const softcd_change* changes,
                                                             uint64_t count, const uint64_t** begins,
                                                             const softcd_change_intersection** intersections);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* NOLINTEND(modernize-*, readability-identifier-naming) */

#endif /* SOFTCD_SOFTCD_PROBE_H */
