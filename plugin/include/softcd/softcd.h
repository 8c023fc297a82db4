#ifndef SOFTCD_SOFTCD_H
#define SOFTCD_SOFTCD_H

/**
 * softcd's interface for C, and for languages that bind to it. Valid as C99 and as C++. It is a thin layer over the C++
 * interface, softcd/softcd.hpp.
 *
 *     softcd_scene* scene;
 *     softcd_query* query;
 *     softcd_body cloth;
 *     softcd_scene_create(NULL, &scene);
 *     softcd_query_create(scene, NULL, &query);
 *     softcd_scene_add_body(scene, triangles, triangle_count, vertex_count, NULL, &cloth);
 *
 *     const softcd_positions x = {sizeof x, SOFTCD_FLOAT32, SOFTCD_HOST, positions, vertex_count, 12, NULL};
 *     softcd_scene_set_positions(scene, cloth, NULL, &x);
 *     softcd_query_detect(query, SOFTCD_PAIRS_ALL, &contacts, &count);
 *
 * Errors. Functions return SOFTCD_OK or an error, which softcd_last_error() describes. After an error everything is as
 * it was, and usable. No exception leaves a function. A pointer must not be NULL unless its description allows that;
 * otherwise the function returns SOFTCD_INVALID_INPUT. A function that fails writes 0, or SOFTCD_NO_BODY, as its
 * result.
 *
 * Threads. Only one thread at a time may use a scene with its queries and probes. Different scenes may be used by
 * different threads.
 *
 * Handles are pointers that a ..._create() returns; give each to ..._destroy() once. Queries and probes of a destroyed
 * scene return SOFTCD_ERROR, and must still be destroyed.
 *
 * Binary interface. Structs that softcd reads or fills in begin with struct_size, the sizeof of the struct. It tells
 * the caller's version: softcd returns SOFTCD_INVALID_INPUT for a size other than its own. ..._init() writes the
 * defaults; a NULL in place of the struct means the same. Compatible versions of softcd only add functions and values;
 * structs stay as they are. Enumerations are integers of 32 bits, as are truth values: 0 is false, all else true.
 * Shared libraries export these names with the version, so that incompatible ones can be in one process.
 */

/* NOLINTBEGIN(modernize-*, readability-identifier-naming): C has neither C++'s words nor its namespaces. */

#include <stdint.h>

/* Both have nothing but macros. */
#include "softcd/export.hpp"
#include "softcd/version.hpp"

#ifdef __cplusplus
extern "C" {
#endif

/** Returns the library's SOFTCD_VERSION (softcd/version.hpp), 10203 for version 1.2.3. The macro is the headers'
 *  version. */
SOFTCD_EXPORT uint32_t softcd_version(void);

/* -- Errors -------------------------------------------------------------------------------------------------------- */

/** The status that functions return. */
typedef int32_t softcd_status;
enum {
  SOFTCD_OK = 0, /**< all went well */
  /** Any other error: a detection waited for twice, a scene that is gone. */
  SOFTCD_ERROR = 1,
  /** The caller's data cannot be used: NULL, an index out of range, arrays of unequal length, an option out of its
   *  range, a struct_size of another version. */
  SOFTCD_INVALID_INPUT = 2,
  /** SOFTCD_BACKEND_CUDA was requested but cannot be used: it was not built, no device exists, or the device failed. */
  SOFTCD_BACKEND_ERROR = 3,
  /** A mesh, its positions or a detection needs more memory than there is. */
  SOFTCD_OUT_OF_MEMORY = 4
};

/** Returns the problem, its cause and the remedy, in UTF-8, for the last function that failed on the calling thread; ""
 *  where none failed. Cut off after 1023 bytes. Valid until the thread's next call that fails. */
SOFTCD_EXPORT const char* softcd_last_error(void);

/* -- Scenes -------------------------------------------------------------------------------------------------------- */

/** Holds bodies, whose contacts queries find, and which probes examine. Every function may be called while a detection
 *  runs; it then concerns the next detection. */
typedef struct softcd_scene softcd_scene;

/** Identifies a body for as long as it is in its scene. Numbers of removed bodies are not reused. */
typedef uint32_t softcd_body;
/** No body. */
#define SOFTCD_NO_BODY UINT32_C(0xFFFFFFFF)

/** The processor that computes detections. */
typedef uint32_t softcd_backend;
enum {
  /** CUDA where a usable device exists and the scene is not tiny, else the CPU; also the CPU when the device fails. */
  SOFTCD_BACKEND_AUTOMATIC = 0,
  SOFTCD_BACKEND_CPU = 1, /**< oneTBB */
  /** An NVIDIA GPU; an error where none exists, or when it fails. */
  SOFTCD_BACKEND_CUDA = 2
};

/** The processor and the memory for the detections on a scene. */
typedef struct softcd_scene_options {
  uint32_t struct_size;   /**< sizeof of this struct */
  softcd_backend backend; /**< SOFTCD_BACKEND_AUTOMATIC */
  /** The most bytes of the backend's memory that the scene may hold at once; 0, the default, for no limit. Where it is
   *  too low for all pairs of triangles at once, they are tested in parts, with the same contacts. Where it is too low
   *  for less than that, a detection returns SOFTCD_OUT_OF_MEMORY. Meshes and positions on the host do not count. */
  uint64_t memory_limit;
  /** The most threads that work on detections on the CPU, including the calling thread; 0, the default, for all
   *  processors. */
  uint32_t max_threads;
  /** The device, as cudaGetDeviceCount counts; -1, the default, for the calling thread's current device. */
  int32_t cuda_device;
  /** A cudaStream_t for the GPU's work that lives as long as the scene; NULL, the default, for a stream of its own. */
  void* cuda_stream;
} softcd_scene_options;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_scene_options). */
SOFTCD_EXPORT softcd_status softcd_scene_options_init(softcd_scene_options* options, uint64_t size);

/** Makes a scene. `options` may be NULL. Returns SOFTCD_BACKEND_ERROR when options->backend is not available. */
SOFTCD_EXPORT softcd_status softcd_scene_create(const softcd_scene_options* options, softcd_scene** scene);
/** Ends running detections and destroys the scene. NULL is allowed. */
SOFTCD_EXPORT void softcd_scene_destroy(softcd_scene* scene);

/** Sets the options. Ends detections that the caller has not waited for, and drops their contacts. With another
 *  backend, device or stream, or a lower memory_limit, drops all queries' contacts. `options` may be NULL. Returns the
 *  errors of softcd_scene_create(). */
SOFTCD_EXPORT softcd_status softcd_scene_set_options(softcd_scene* scene, const softcd_scene_options* options);

/** Returns the backend of the last detection, or the expected one before the first. Never SOFTCD_BACKEND_AUTOMATIC. */
SOFTCD_EXPORT softcd_status softcd_scene_backend(const softcd_scene* scene, softcd_backend* backend);

/** The importance of a log message. */
typedef uint32_t softcd_log_level;
enum { SOFTCD_LOG_INFORMATION = 0, SOFTCD_LOG_WARNING = 1 };

/** Receives log messages. `text` ends with 0 and is invalid after the call. Called on the thread that calls a function
 *  of the scene, its queries or probes. It must not call these, and must return: no exception, no longjmp. */
typedef void (*softcd_log)(void* user_data, softcd_log_level level, const char* text);

/** Sets the function that receives warnings and other messages from now on. NULL, the default, turns them off. */
SOFTCD_EXPORT softcd_status softcd_scene_set_log(softcd_scene* scene, softcd_log log, void* user_data);

/* -- Bodies -------------------------------------------------------------------------------------------------------- */

/** A body's settings. They may change from one detection to the next, without a change of topology. */
typedef struct softcd_body_settings {
  uint32_t struct_size; /**< sizeof of this struct */
  /** Two features are in contact when their distance is at most the sum of their bodies' margins. Unit: the
   *  positions'. Finite, at least 0, the default. */
  float margin;
  /** Bodies a and b are compared when (a.filter_group & b.filter_mask) and (b.filter_group & a.filter_mask). Defaults:
   *  1 and all bits. */
  uint32_t filter_group;
  uint32_t filter_mask; /**< see filter_group */
  /** If not 0, also finds contacts between features of this body that share no vertex, whatever its group and mask.
   *  Default: 1. */
  uint32_t self_collision;
  /** If not 0, the application moves the body. Two such bodies are never compared, nor is one with itself. Default:
   *  0. */
  uint32_t kinematic;
  /** The pairs of features that the body takes part in. A kind is tested when both bodies take part. Default: 1. */
  uint32_t vertex_triangle;
  uint32_t edge_edge; /**< see vertex_triangle */
  /** Bodies of different batches never touch, wherever they are. Default: 0. */
  uint32_t batch;
  /** Features of this body that are connected by a path of fewer edges than this are never in contact. With 1, the
   *  default, features that share a vertex are excluded; with 2, also features whose vertices are joined by an edge;
   *  and so on, up to 16. */
  uint32_t neighbour_rings;
  /** Features of this body are never in contact if their distance in the rest positions is at most this (see
   *  softcd_scene_set_rest_positions()). Finite, at least 0, the default, which excludes none. Above 0 with
   *  self_collision, a detection returns SOFTCD_INVALID_INPUT unless rest positions were set. */
  float rest_distance;
} softcd_body_settings;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_body_settings). */
SOFTCD_EXPORT softcd_status softcd_body_settings_init(softcd_body_settings* settings, uint64_t size);

/** Adds a mesh: 3 * triangle_count indices of vertices, each below vertex_count, read during the call. A vertex in no
 *  triangle does not collide, unless a triangle {v, v, v} is added for it. `triangles` may be NULL where there are
 *  none; `settings` may be NULL. Returns SOFTCD_INVALID_INPUT where an index or a setting is out of range. */
SOFTCD_EXPORT softcd_status softcd_scene_add_body(softcd_scene* scene, const uint32_t* triangles,
                                                  uint64_t triangle_count, uint32_t vertex_count,
                                                  const softcd_body_settings* settings, softcd_body* body);
/** Replaces a body's topology, vertex count and settings. Its positions must be set again. Returns the errors of
 *  softcd_scene_add_body(), and SOFTCD_INVALID_INPUT where there is no such body. */
SOFTCD_EXPORT softcd_status softcd_scene_update_body(softcd_scene* scene, softcd_body body, const uint32_t* triangles,
                                                     uint64_t triangle_count, uint32_t vertex_count,
                                                     const softcd_body_settings* settings);

/** A mesh with segments, which model ropes and hair: edges without a triangle. */
typedef struct softcd_mesh {
  uint32_t struct_size;      /**< sizeof of this struct */
  uint32_t vertex_count;     /**< the number of positions to set */
  const uint32_t* triangles; /**< 3 * triangle_count indices of vertices; may be NULL where there are none */
  uint64_t triangle_count;   /**< the number of triangles */
  /** 2 * segment_count indices of vertices; may be NULL where there are none. A segment's vertices touch triangles.
   *  With edge_edge of softcd_body_settings, its edge touches edges of triangles and of other segments. Only by this
   *  contact do segments touch each other. Segments that share a vertex do not touch. Their edges are numbered behind
   *  the triangles' edges. A probe or a count of triangles treats segment i as triangle triangle_count + i. */
  const uint32_t* segments;
  uint64_t segment_count; /**< the number of segments */
} softcd_mesh;

/** Adds a mesh that may have segments; else as softcd_scene_add_body(). */
SOFTCD_EXPORT softcd_status softcd_scene_add_mesh(softcd_scene* scene, const softcd_mesh* mesh,
                                                  const softcd_body_settings* settings, softcd_body* body);
/** Replaces a body's mesh, which may have segments. Without segments the cost depends on the size of the change, which
 *  serves meshes that are cut, torn, refined or made coarser. The function reads the triangles with indices among the
 *  `changed_count` of `changed` (in any order), and those behind the last that the body had. It keeps all other
 *  triangles. If there are fewer triangles than before, those behind the last are removed. Remaining edges keep their
 *  indices. All positions must be set again. Continuous detections take a new vertex's position at t0 as the start of
 *  its path.
 *
 *  `changed` may be NULL where `changed_count` is 0: all triangles are then read. They are also all read where the body
 *  had segments or gets some. The first call with `changed` after a call without it, and the detection after that call,
 *  cost about as much as one without. Returns SOFTCD_INVALID_INPUT also when an index of `changed` is out of range, or
 *  a vertex index of a kept triangle is. */
SOFTCD_EXPORT softcd_status softcd_scene_update_mesh(softcd_scene* scene, softcd_body body, const softcd_mesh* mesh,
                                                     const softcd_body_settings* settings, const uint32_t* changed,
                                                     uint64_t changed_count);
/** Sets a body's settings. `settings` may be NULL. */
SOFTCD_EXPORT softcd_status softcd_scene_set_settings(softcd_scene* scene, softcd_body body,
                                                      const softcd_body_settings* settings);
/** Removes a body. Returns SOFTCD_INVALID_INPUT where there is no such body. */
SOFTCD_EXPORT softcd_status softcd_scene_remove_body(softcd_scene* scene, softcd_body body);
/** Sets `has_body` to 1 where the body was added and not removed, else to 0. */
SOFTCD_EXPORT softcd_status softcd_scene_has_body(const softcd_scene* scene, softcd_body body, uint32_t* has_body);

/** The type of coordinates. */
typedef uint32_t softcd_scalar;
enum { SOFTCD_FLOAT32 = 0, SOFTCD_FLOAT64 = 1 };

/** The memory that positions are in. */
typedef uint32_t softcd_memory;
enum { SOFTCD_HOST = 0, SOFTCD_CUDA_DEVICE = 1 };

/** A view of `count` positions of three consecutive coordinates, `stride` bytes apart, aligned as their coordinates
 *  are. softcd/positions.hpp describes the precision for doubles. */
typedef struct softcd_positions {
  uint32_t struct_size; /**< sizeof of this struct */
  softcd_scalar scalar; /**< the type of coordinates */
  softcd_memory memory; /**< the memory of `data` */
  /** The first x. On the host: the scene's next detection reads the memory before the call that starts it returns, and
   *  never again. On the scene's CUDA device: the memory is not copied. It must hold the positions, unchanged, while a
   *  detection runs, and until the body's positions are set again or the body is removed. */
  const void* data;
  uint64_t count;  /**< the body's number of vertices */
  uint64_t stride; /**< bytes from one x to the next */
  /** For positions on a device, a cudaEvent_t after which they are there, or NULL. A detection also waits for work that
   *  was enqueued on the device's legacy default stream before the detection started. */
  void* ready;
} softcd_positions;

/** Sets the positions of the body's vertices at both ends of the step. With NULL for x_t0, the body does not move from
 *  x_t1. Returns SOFTCD_INVALID_INPUT when a count is not the body's, a pointer is null, or a stride is shorter than a
 *  position. Also returns it when the ends have two types or are in two places. Returns SOFTCD_BACKEND_ERROR for
 *  positions on a device where the scene cannot use one. */
SOFTCD_EXPORT softcd_status softcd_scene_set_positions(softcd_scene* scene, softcd_body body,
                                                       const softcd_positions* x_t0, const softcd_positions* x_t1);

/** Two bodies, in either order, or a body and itself. */
typedef struct softcd_body_pair {
  softcd_body a; /**< one body */
  softcd_body b; /**< the other one */
} softcd_body_pair;

/** Sets the pairs of bodies that no query compares from the next detection on. Replaces the pairs that were set before.
 *  Returns SOFTCD_INVALID_INPUT when a body is not in the scene; nothing is then changed. `pairs` may be NULL where
 *  there are none. */
SOFTCD_EXPORT softcd_status softcd_scene_set_ignored_pairs(softcd_scene* scene, const softcd_body_pair* pairs,
                                                           uint64_t count);

/** Filter bits of a vertex. Vertices a and b may touch when (a.group & b.mask) and (b.group & a.mask). Two features may
 *  touch when some vertex of the one and some vertex of the other may. */
typedef struct softcd_vertex_filter {
  uint32_t group; /**< the groups that the vertex is in; 1 in bodies without filters */
  uint32_t mask;  /**< the groups that it may touch; all bits in bodies without filters */
} softcd_vertex_filter;

/** Sets a filter for each vertex of the body, or none. It restricts the features of other bodies and of its own body
 *  that the vertex may touch, in addition to the bodies' groups and masks. Copied, and dropped when the body is
 *  updated. Returns SOFTCD_INVALID_INPUT where the number of filters is neither 0 nor the body's vertex count. */
SOFTCD_EXPORT softcd_status softcd_scene_set_vertex_filters(softcd_scene* scene, softcd_body body,
                                                            const softcd_vertex_filter* filters, uint64_t count);
/** Sets the body's rest positions, in any place, for rest_distance; NULL removes them. They must be in host memory.
 *  Copied, and dropped when the body is updated. Returns the errors of softcd_scene_set_positions(), and
 *  SOFTCD_INVALID_INPUT when a coordinate is not finite. */
SOFTCD_EXPORT softcd_status softcd_scene_set_rest_positions(softcd_scene* scene, softcd_body body,
                                                            const softcd_positions* x);

/* -- Queries ------------------------------------------------------------------------------------------------------- */

/** Finds contacts between the bodies of a scene. The same input gives the same bytes, whatever the number of threads
 *  or backend. The detections of one scene run one after another. */
typedef struct softcd_query softcd_query;

/** The compared motion. */
typedef uint32_t softcd_detection;
enum {
  SOFTCD_DCD = 0, /**< positions at one end of the step */
  SOFTCD_CCD = 1  /**< straight-line motion from t0 to t1 */
};

/** The narrow phase's arithmetic, and what it guarantees: docs/measured/accuracy.md. */
typedef uint32_t softcd_accuracy;
enum {
  SOFTCD_FAST = 0,         /**< float32 */
  SOFTCD_PRECISE = 1,      /**< float64 */
  SOFTCD_CONSERVATIVE = 2, /**< float64; finds everything that comes within a margin, also along the path */
  /** SOFTCD_CONSERVATIVE where positions of some body are double, and in a continuous detection with margins; else
   *  SOFTCD_PRECISE */
  SOFTCD_ACCURACY_AUTOMATIC = 3
};

/** How pairs of triangles are found. No choice ever loses one. */
typedef uint32_t softcd_broad_phase;
enum {
  SOFTCD_EXACT = 0,  /**< virtual subdivision with exact control bits */
  SOFTCD_UNIFORM = 1 /**< one grid sized by the largest triangle: many more tests */
};

/** The rule by which a vertex and a triangle are in contact in a discrete detection. */
typedef uint32_t softcd_contact_rule;
enum {
  SOFTCD_DISTANCE = 0, /**< at most a margin apart */
  SOFTCD_SLAB = 1,     /**< Bullet's rule for deformable bodies: at most a margin from the triangle's plane */
  SOFTCD_AHEAD = 2     /**< Bullet's rule for classic soft bodies: of what motion_margin finds, what lies ahead */
};

/** An end of the step. */
typedef uint32_t softcd_step_end;
enum { SOFTCD_T0 = 0, SOFTCD_T1 = 1 };

/** The options of a query. */
typedef struct softcd_query_options {
  uint32_t struct_size;             /**< sizeof of this struct */
  softcd_detection detection;       /**< SOFTCD_DCD */
  softcd_accuracy accuracy;         /**< SOFTCD_ACCURACY_AUTOMATIC */
  softcd_broad_phase broad_phase;   /**< SOFTCD_EXACT */
  softcd_contact_rule contact_rule; /**< SOFTCD_DISTANCE */
  softcd_step_end step_end;         /**< of a discrete detection: SOFTCD_T1 */
  /** If 0, no triangle is split. Changes only the number of tests, not the contacts. Default: 1. */
  uint32_t subdivision;
  /** Cell size of SOFTCD_EXACT in mean bounding radii of triangles, 0.1 to 100; 0, the default, chooses one. */
  float cell_size_factor;
  /** Discrete detection only: enlarges a vertex's margin against triangles of other bodies by this many times its
   *  distance from t0 to t1. At least 0, the default. */
  float motion_margin;
  /** If 0, every body's margin counts as 0. Default: 1. */
  uint32_t margins;
  /** The kinds of feature pairs to test. Two bodies are tested for a kind when both bodies and the query want it.
   *  Defaults: 1. */
  uint32_t vertex_triangle;
  uint32_t edge_edge; /**< see vertex_triangle */
  /** If not 0, and without memory_limit, near pairs of triangles are found once and serve several detections, until
   *  many triangles leave their volumes. Takes memory, changes no contacts. Default: 1. */
  uint32_t reuse_pairs;
  /** If not 0, contacts stay in the memory of the scene's CUDA device; see softcd_query_wait_on_device(). Only for
   *  scenes with SOFTCD_BACKEND_CUDA. Default: 0. */
  uint32_t contacts_on_device;
  /** If 0, ignores bodies' neighbour_rings and rest_distance. Default: 1. */
  uint32_t neighbour_filters;
} softcd_query_options;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_query_options). */
SOFTCD_EXPORT softcd_status softcd_query_options_init(softcd_query_options* options, uint64_t size);

/** Makes a query on the scene. `options` may be NULL. Returns SOFTCD_INVALID_INPUT when an option is out of range. */
SOFTCD_EXPORT softcd_status softcd_query_create(softcd_scene* scene, const softcd_query_options* options,
                                                softcd_query** query);
/** Ends a running detection and destroys the query. NULL is allowed. */
SOFTCD_EXPORT void softcd_query_destroy(softcd_query* query);
/** Sets the options. Ends a running detection of the query and drops its contacts. `options` may be NULL. */
SOFTCD_EXPORT softcd_status softcd_query_set_options(softcd_query* query, const softcd_query_options* options);

/** Decides which pairs of bodies a detection compares; 0 excludes the pair. Called on the thread that starts the
 *  detection, with a <= b, for pairs that pass groups, masks, bounding boxes and lists of pairs. Called with a == b for
 *  bodies that collide with themselves. It must not call the scene, its queries or probes, and must return: no
 *  exception, no longjmp. */
typedef uint32_t (*softcd_pair_filter)(void* user_data, softcd_body a, softcd_body b);

/** Sets the filter that every later detection asks. NULL, the default, admits all pairs. */
SOFTCD_EXPORT softcd_status softcd_query_set_pair_filter(softcd_query* query, softcd_pair_filter filter,
                                                         void* user_data);
/** Restricts later detections to these pairs. An empty list, the default, restricts nothing. */
SOFTCD_EXPORT softcd_status softcd_query_set_only_pairs(softcd_query* query, const softcd_body_pair* pairs,
                                                        uint64_t count);

/** The kind of touching features. */
typedef uint8_t softcd_contact_kind;
enum { SOFTCD_VERTEX_TRIANGLE = 0, SOFTCD_EDGE_EDGE = 1 };

/** Two features in contact. Indices count within their own body. 72 bytes. */
typedef struct softcd_contact {
  softcd_contact_kind kind; /**< which features touch */
  /** 1: reported because SOFTCD_CONSERVATIVE reached its bound on work before it could decide; else 0. */
  uint8_t is_unsettled;
  uint16_t unused;    /**< 0 */
  softcd_body body_a; /**< the vertex's body, or the first edge's */
  softcd_body body_b; /**< the triangle's body, or the second edge's */
  /** Vertex and triangle, or the two edges: a body's edges are numbered in the order of their sorted vertex pairs. */
  uint32_t feature_a;
  uint32_t feature_b; /**< the same for body_b */
  /** The vertex, then the triangle's three; or the first edge's, lower one first, then the second's. */
  uint32_t vertices[4];
  /** The point on each feature: {1, w0, w1, w2}, or {u0, u1, w0, w1}. Each side sums to 1. */
  float weights[4];
  /** Unit vector from side b's point towards side a's. With SOFTCD_CCD it points to the side that a came from. */
  float normal[3];
  float distance;       /**< between the two points at time_of_impact; unit: the positions' */
  float time_of_impact; /**< in [0, 1], t0 to t1; 1 for a discrete detection */
} softcd_contact;

/** The pairs of bodies that a detection compares, of those that groups, masks, boxes and the filter admit. */
typedef uint32_t softcd_pairs;
enum {
  SOFTCD_PAIRS_ALL = 0,
  /** Pairs with a body that was added or updated, or given positions or settings, since the query's last detection. */
  SOFTCD_PAIRS_CHANGED = 1
};

/** Reads positions that were set, and starts a detection. Bodies without positions are left out, with a warning. So are
 *  triangles with a vertex that is not finite. The contacts of the query's previous detection are dropped. */
SOFTCD_EXPORT softcd_status softcd_query_start(softcd_query* query, softcd_pairs pairs);
/** Waits for the detection that was started last. Callable once. Writes all contacts, each once, sorted by (kind,
 *  body_a, feature_a, body_b, feature_b). They are in the query's memory, and stay valid until the query starts its
 *  next detection, its options are set, or it is destroyed. Returns the error of a detection that failed. Returns
 *  SOFTCD_ERROR where no detection was started, where it was waited for already, or where contacts are on the
 *  device. */
SOFTCD_EXPORT softcd_status softcd_query_wait(softcd_query* query, const softcd_contact** contacts, uint64_t* count);

/** Contacts in a CUDA device's memory, as softcd_query_wait() would return them, and valid as long as those. */
typedef struct softcd_device_contacts {
  uint32_t struct_size;       /**< sizeof of this struct */
  int32_t device;             /**< as cudaGetDeviceCount counts them */
  const softcd_contact* data; /**< on that device */
  uint64_t count;             /**< the number of contacts */
  /** On that device, 2 * body_ids + 1 values. Contacts [body_begin[k * body_ids + b], body_begin[k * body_ids + b + 1])
   *  are those of kind k whose body_a is b. NULL where no bodies were compared. */
  const uint64_t* body_begin;
  uint32_t body_ids; /**< all bodies' numbers are below this */
} softcd_device_contacts;

/** Waits for the detection of a query with contacts_on_device. All contacts are on the device when it returns. Fills in
 *  *contacts, whose struct_size the caller has set. */
SOFTCD_EXPORT softcd_status softcd_query_wait_on_device(softcd_query* query, softcd_device_contacts* contacts);

/** Counters on the device of a detection that leaves its contacts there. */
typedef struct softcd_contact_counts {
  uint64_t contacts; /**< number of contacts found; those beyond the capacity are not stored */
  /** 1: all contacts are stored, in order. 0: a list was too short, or a prediction was wrong. The stored contacts are
   *  then useless, and waiting for the detection repeats it. */
  uint32_t is_complete;
  uint32_t unused; /**< 0 */
} softcd_contact_counts;

/** Contacts in a CUDA device's memory, of a detection that may still run. For work that is enqueued on that device. */
typedef struct softcd_pending_contacts {
  uint32_t struct_size;       /**< sizeof of this struct */
  int32_t device;             /**< as cudaGetDeviceCount counts them */
  const softcd_contact* data; /**< on that device, once `ready` has happened */
  uint64_t capacity;          /**< the number of contacts that fit */
  /** On that device: the number of contacts, and whether all are stored. NULL where no bodies are compared: there are
   *  no contacts. */
  const softcd_contact_counts* counts;
  const uint64_t* body_begin; /**< see softcd_device_contacts */
  uint32_t body_ids;          /**< see softcd_device_contacts */
  void* ready;                /**< a cudaEvent_t after which all results are there */
} softcd_pending_contacts;

/** Writes where the contacts of a query with contacts_on_device will be, without waiting for them: those of the
 *  detection that was started last. A stream that waits for `ready` may read them.
 *
 *  Only the counts say whether the contacts are complete, either on the device or after softcd_query_wait_on_device().
 *  Where they are not, softcd_query_wait_on_device() repeats the detection; positions on the device must not change
 *  until then. Fills in *contacts, whose struct_size the caller has set. Valid as long as the result of
 *  softcd_query_wait_on_device(), whose errors it returns. */
SOFTCD_EXPORT softcd_status softcd_query_on_device(softcd_query* query, softcd_pending_contacts* contacts);

/** Calls softcd_query_start() and softcd_query_wait(). */
SOFTCD_EXPORT softcd_status softcd_query_detect(softcd_query* query, softcd_pairs pairs,
                                                const softcd_contact** contacts, uint64_t* count);

/** Counts of the last detection that the caller has waited for. softcd/core/statistics.hpp has more about each. */
typedef struct softcd_statistics {
  uint32_t struct_size;        /**< sizeof of this struct */
  softcd_backend backend;      /**< where it was computed: never SOFTCD_BACKEND_AUTOMATIC */
  uint64_t bodies;             /**< in the scene */
  uint64_t triangles;          /**< in the scene */
  uint64_t vertices;           /**< in the scene */
  uint64_t edges;              /**< in the scene */
  uint64_t active_triangles;   /**< those whose body's box and filters allow a partner */
  uint64_t left_out_triangles; /**< those with a vertex that is not finite */
  uint64_t triangle_pairs;     /**< those that passed every test of the broad phase */
  uint64_t vt_candidates;      /**< tested pairs of a vertex and a triangle */
  uint64_t ee_candidates;      /**< tested pairs of edges */
  uint64_t vt_contacts;        /**< touching pairs of a vertex and a triangle */
  uint64_t ee_contacts;        /**< touching pairs of edges */
  uint64_t unsettled_contacts; /**< contacts with softcd_contact::is_unsettled */
  double earliest_toi;         /**< the earliest time of impact; 1 without contacts */
  uint64_t peak_bytes;         /**< the most bytes of the backend's memory that were in use at once */
  uint64_t reruns;             /**< stages, or detections, that were repeated because lists had to grow */
  uint64_t chunks;             /**< parts in which the pairs were tested */
  double total_ms;             /**< the detection's time, in milliseconds */
} softcd_statistics;

/** Fills in *statistics, whose struct_size the caller has set. */
SOFTCD_EXPORT softcd_status softcd_query_statistics(const softcd_query* query, softcd_statistics* statistics);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* NOLINTEND(modernize-*, readability-identifier-naming) */

/* The part about probes. */
#include "softcd/softcd_probe.h"

#endif /* SOFTCD_SOFTCD_H */
