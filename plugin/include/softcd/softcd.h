#ifndef SOFTCD_SOFTCD_H
#define SOFTCD_SOFTCD_H

/**
 * softcd's interface for C, and for languages that bind to it. Valid as C99 and as C++; the C++ interface is
 * softcd/softcd.hpp, which this one is a thin layer over.
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
 * Errors. Functions return SOFTCD_OK, or what has gone wrong, which softcd_last_error() puts into words; everything is
 * as it was then, and usable. No exception leaves a function. A pointer is required unless it is said that it may be
 * NULL: where it is, the function returns SOFTCD_INVALID_INPUT. Results are written where all went well, else 0, or
 * SOFTCD_NO_BODY.
 *
 * Threads. One thread at a time for a scene with its queries and probes; several scenes may be used from several
 * threads.
 *
 * Handles are pointers that a ..._create() returns, to be given to ..._destroy() once. Queries and probes of a scene
 * that was destroyed return SOFTCD_ERROR, and are still to be destroyed.
 *
 * Binary interface. Structs that softcd reads or fills in begin with struct_size, sizeof of the struct, by which it
 * knows the caller's version; a size other than its own is SOFTCD_INVALID_INPUT. ..._init() writes the defaults, as a
 * NULL in place of the struct gives. Compatible versions of softcd only add functions and values; structs stay as they
 * are. Enumerations are integers of 32 bits, as are truth values: 0 is false, all else true. Shared libraries show
 * these names with the version, so that incompatible ones can be in one process.
 */

/* NOLINTBEGIN(modernize-*, readability-identifier-naming): C has neither C++'s words nor its namespaces. */

#include <stdint.h>

/* Both have nothing but macros. */
#include "softcd/export.hpp"
#include "softcd/version.hpp"

#ifdef __cplusplus
extern "C" {
#endif

/** The library's SOFTCD_VERSION (softcd/version.hpp), 10203 for version 1.2.3; the headers' is the macro. */
SOFTCD_EXPORT uint32_t softcd_version(void);

/* -- Errors -------------------------------------------------------------------------------------------------------- */

/** What a function returns. */
typedef int32_t softcd_status;
enum {
  SOFTCD_OK = 0, /**< all went well */
  /** All that is none of the others: a detection waited for twice, a scene that is gone. */
  SOFTCD_ERROR = 1,
  /** The caller's data cannot be used: NULL, an index out of range, arrays of unequal length, an option out of its
   *  range, a struct_size of another version. */
  SOFTCD_INVALID_INPUT = 2,
  /** SOFTCD_BACKEND_CUDA was asked for and cannot be had: not built in, no device, or the device failed. */
  SOFTCD_BACKEND_ERROR = 3,
  /** A mesh, its positions or a detection would need more memory than there is. */
  SOFTCD_OUT_OF_MEMORY = 4
};

/** The problem, its cause and the remedy, in UTF-8, of the last function that failed on the calling thread; "" where
 *  none has. Cut off after 1023 bytes. Valid until the thread's next call that fails. */
SOFTCD_EXPORT const char* softcd_last_error(void);

/* -- Scenes -------------------------------------------------------------------------------------------------------- */

/** Bodies, of which queries find the contacts, and which probes are asked about. Everything may be called while a
 *  detection runs, and concerns the next one that is started. */
typedef struct softcd_scene softcd_scene;

/** A body's number for as long as it is in its scene. Numbers of removed bodies are not used again. */
typedef uint32_t softcd_body;
/** No body. */
#define SOFTCD_NO_BODY UINT32_C(0xFFFFFFFF)

/** Where detections are computed. */
typedef uint32_t softcd_backend;
enum {
  /** CUDA where there is a usable device and the scene is not tiny, else the CPU, also when the device fails. */
  SOFTCD_BACKEND_AUTOMATIC = 0,
  SOFTCD_BACKEND_CPU = 1, /**< oneTBB */
  /** An NVIDIA GPU; an error where there is none, or when it fails. */
  SOFTCD_BACKEND_CUDA = 2
};

/** Where the detections on a scene run, and with how much memory. */
typedef struct softcd_scene_options {
  uint32_t struct_size;   /**< sizeof of this struct */
  softcd_backend backend; /**< SOFTCD_BACKEND_AUTOMATIC */
  /** Most bytes of the backend's memory that the scene may hold at once; 0, the default, for no limit. Where they do
   *  not suffice for all pairs of triangles at once these are tested in parts, with the same contacts; where they do
   *  not suffice for less, a detection is SOFTCD_OUT_OF_MEMORY. Meshes and positions on the host do not count. */
  uint64_t memory_limit;
  /** Most threads that work on detections on the CPU, the calling one included; 0, the default, for all processors. */
  uint32_t max_threads;
  /** As cudaGetDeviceCount counts; -1, the default, for the calling thread's current one. */
  int32_t cuda_device;
  /** A cudaStream_t for the GPU's work that lives as long as the scene; NULL, the default, for one of the scene's. */
  void* cuda_stream;
} softcd_scene_options;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_scene_options). */
SOFTCD_EXPORT softcd_status softcd_scene_options_init(softcd_scene_options* options, uint64_t size);

/** `options` may be NULL. SOFTCD_BACKEND_ERROR when options->backend cannot be had. */
SOFTCD_EXPORT softcd_status softcd_scene_create(const softcd_scene_options* options, softcd_scene** scene);
/** Ends detections that run. NULL is nothing to destroy. */
SOFTCD_EXPORT void softcd_scene_destroy(softcd_scene* scene);

/** Ends detections that were not waited for, whose contacts are lost; with another backend, device or stream, or a
 *  lower memory_limit, all queries' contacts are. `options` may be NULL. Returns what softcd_scene_create() does. */
SOFTCD_EXPORT softcd_status softcd_scene_set_options(softcd_scene* scene, const softcd_scene_options* options);

/** The backend of the last detection, before the first one the expected: never SOFTCD_BACKEND_AUTOMATIC. */
SOFTCD_EXPORT softcd_status softcd_scene_backend(const softcd_scene* scene, softcd_backend* backend);

/** How much a line of the log matters. */
typedef uint32_t softcd_log_level;
enum { SOFTCD_LOG_INFORMATION = 0, SOFTCD_LOG_WARNING = 1 };

/** `text` ends with 0 and is gone when the call returns. Called on the thread that calls a function of the scene, its
 *  queries or probes. It must not call these, and must return: no exception, no longjmp. */
typedef void (*softcd_log)(void* user_data, softcd_log_level level, const char* text);

/** `log` is told warnings and what else may be of interest from now on. NULL, as at first, for nobody. */
SOFTCD_EXPORT softcd_status softcd_scene_set_log(softcd_scene* scene, softcd_log log, void* user_data);

/* -- Bodies -------------------------------------------------------------------------------------------------------- */

/** What may change from one detection to the next without a change of topology. */
typedef struct softcd_body_settings {
  uint32_t struct_size; /**< sizeof of this struct */
  /** Two features are in contact when their distance is at most the sum of their bodies' margins. Unit: the
   *  positions'. Finite, at least 0, the default. */
  float margin;
  /** Bodies a and b are compared when (a.filter_group & b.filter_mask) and (b.filter_group & a.filter_mask). Defaults:
   *  1 and all bits. */
  uint32_t filter_group;
  uint32_t filter_mask; /**< see filter_group */
  /** Also find contacts between features of this body that share no vertex, whatever its group and mask. Default: 1. */
  uint32_t self_collision;
  /** Moved by somebody else: two such bodies are never compared, nor is one with itself. Default: 0. */
  uint32_t kinematic;
  /** Which pairs of features the body takes part in; a kind is tested where both bodies want it. Default: 1. */
  uint32_t vertex_triangle;
  uint32_t edge_edge; /**< see vertex_triangle */
  /** Bodies of different batches never touch, wherever they are. Default: 0. */
  uint32_t batch;
  /** Features of this body that a path of fewer edges than this joins are no contact. 1, the default: those that share
   *  a vertex; 2: also those with vertices that an edge joins, and so on, to 16. */
  uint32_t neighbour_rings;
  /** Features of this body that are at most so far apart where softcd_scene_set_rest_positions() says are no contact;
   *  with self_collision SOFTCD_INVALID_INPUT of a detection where nobody has said it. Finite, at least 0, the default,
   *  which excludes none. */
  float rest_distance;
} softcd_body_settings;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_body_settings). */
SOFTCD_EXPORT softcd_status softcd_body_settings_init(softcd_body_settings* settings, uint64_t size);

/** Adds a mesh: 3 * triangle_count indices of vertices, each below vertex_count, read during the call. A vertex in no
 *  triangle does not collide; give it a triangle {v, v, v} when it should. `triangles` may be NULL where there are
 *  none, `settings` may be NULL. SOFTCD_INVALID_INPUT where an index or a setting is out of range. */
SOFTCD_EXPORT softcd_status softcd_scene_add_body(softcd_scene* scene, const uint32_t* triangles,
                                                  uint64_t triangle_count, uint32_t vertex_count,
                                                  const softcd_body_settings* settings, softcd_body* body);
/** New topology, vertex count and settings for a body, whose positions have to be set again. As
 *  softcd_scene_add_body(), and SOFTCD_INVALID_INPUT where there is no such body. */
SOFTCD_EXPORT softcd_status softcd_scene_update_body(softcd_scene* scene, softcd_body body, const uint32_t* triangles,
                                                     uint64_t triangle_count, uint32_t vertex_count,
                                                     const softcd_body_settings* settings);

/** A mesh with segments: ropes and hair, what collides without being a triangle's side. */
typedef struct softcd_mesh {
  uint32_t struct_size;      /**< sizeof of this struct */
  uint32_t vertex_count;     /**< as many positions are set */
  const uint32_t* triangles; /**< 3 * triangle_count indices of vertices; may be NULL where there are none */
  uint64_t triangle_count;   /**< how many there are */
  /** 2 * segment_count indices of vertices; may be NULL where there are none. A segment's vertices touch triangles; its
   *  edge touches edges, of triangles and of other segments, with edge_edge of softcd_body_settings: by that alone
   *  segments touch each other, but those that share a vertex. Their edges are numbered behind those of triangles.
   * Where triangles are counted, or named by a probe, segment i is triangle triangle_count + i. */
  const uint32_t* segments;
  uint64_t segment_count; /**< how many there are */
} softcd_mesh;

/** softcd_scene_add_body() for what has segments. */
SOFTCD_EXPORT softcd_status softcd_scene_add_mesh(softcd_scene* scene, const softcd_mesh* mesh,
                                                  const softcd_body_settings* settings, softcd_body* body);
/** softcd_scene_update_body() for what has segments, and, where it has none, at the cost of what has changed: where a
 *  mesh is cut, torn, refined or made coarser. Of the triangles those are read whose indices are among the
 *  `changed_count` of `changed`, in any order, and those behind the last that the body had. The others are as they
 * were; where there are fewer, those behind the last are gone. Edges that stay keep their indices. All positions have
 * to be set again: those of new vertices at t0 are what continuous detections take for the start of their way.
 *
 *  `changed` may be NULL where `changed_count` is 0: all triangles are read then, as they are where the body had
 * segments or gets some. The first call with `changed` after one without, and the detection after it, cost about as
 * much as one without. SOFTCD_INVALID_INPUT also when an index of `changed` is out of range, or a vertex of a triangle
 * that stays. */
SOFTCD_EXPORT softcd_status softcd_scene_update_mesh(softcd_scene* scene, softcd_body body, const softcd_mesh* mesh,
                                                     const softcd_body_settings* settings, const uint32_t* changed,
                                                     uint64_t changed_count);
/** `settings` may be NULL. */
SOFTCD_EXPORT softcd_status softcd_scene_set_settings(softcd_scene* scene, softcd_body body,
                                                      const softcd_body_settings* settings);
/** SOFTCD_INVALID_INPUT where there is no such body. */
SOFTCD_EXPORT softcd_status softcd_scene_remove_body(softcd_scene* scene, softcd_body body);
/** `has_body` is 1 where the body was added and not removed, else 0. */
SOFTCD_EXPORT softcd_status softcd_scene_has_body(const softcd_scene* scene, softcd_body body, uint32_t* has_body);

/** The type of coordinates. */
typedef uint32_t softcd_scalar;
enum { SOFTCD_FLOAT32 = 0, SOFTCD_FLOAT64 = 1 };

/** Where positions are. */
typedef uint32_t softcd_memory;
enum { SOFTCD_HOST = 0, SOFTCD_CUDA_DEVICE = 1 };

/** `count` positions of three consecutive coordinates, `stride` bytes apart, aligned as their coordinates are. What
 *  the detector makes of doubles, softcd/positions.hpp tells. */
typedef struct softcd_positions {
  uint32_t struct_size; /**< sizeof of this struct */
  softcd_scalar scalar; /**< the type of coordinates */
  softcd_memory memory; /**< where `data` is */
  /** The first x. On the host: read by the scene's next detection that is started, before that call returns, and never
   *  after. On the scene's CUDA device: not copied, it must hold them, unchanged, until the body's positions are set
   *  again or the body is removed, and as long as a detection runs. */
  const void* data;
  uint64_t count;  /**< as many as the body has vertices */
  uint64_t stride; /**< bytes from one x to the next */
  /** For positions on a device a cudaEvent_t after which they are there, or NULL. What was enqueued on the device's
   *  legacy default stream when a detection starts is waited for as well. */
  void* ready;
} softcd_positions;

/** Where the body's vertices are at both ends of the step. NULL for x_t0: where x_t1 says, the body does not move.
 *  SOFTCD_INVALID_INPUT when a count is not the body's, a pointer is null, a stride is shorter than a position, or
 *  the ends are of two types or in two places; SOFTCD_BACKEND_ERROR for positions on a device where the scene cannot
 *  use one. */
SOFTCD_EXPORT softcd_status softcd_scene_set_positions(softcd_scene* scene, softcd_body body,
                                                       const softcd_positions* x_t0, const softcd_positions* x_t1);

/** Two bodies, in either order, or a body and itself. */
typedef struct softcd_body_pair {
  softcd_body a; /**< the one */
  softcd_body b; /**< and the other */
} softcd_body_pair;

/** These pairs are not compared by any query from the next detection on, instead of those that were given before.
 *  SOFTCD_INVALID_INPUT when a body is not in the scene; nothing is changed then. `pairs` may be NULL where there are
 *  none. */
SOFTCD_EXPORT softcd_status softcd_scene_set_ignored_pairs(softcd_scene* scene, const softcd_body_pair* pairs,
                                                           uint64_t count);

/** What a vertex may touch. Two features may touch where some vertex of the one and some vertex of the other have
 *  (a.group & b.mask) and (b.group & a.mask). */
typedef struct softcd_vertex_filter {
  uint32_t group; /**< 1 where there are none */
  uint32_t mask;  /**< all bits where there are none */
} softcd_vertex_filter;

/** What the body's vertices may touch, of other bodies and of its own, beside what bodies' groups and masks decide. One
 *  for each vertex, or none. Copied; gone when the body is updated. SOFTCD_INVALID_INPUT where their number is
 *  neither. */
SOFTCD_EXPORT softcd_status softcd_scene_set_vertex_filters(softcd_scene* scene, softcd_body body,
                                                            const softcd_vertex_filter* filters, uint64_t count);
/** Where the body's vertices are at rest, in whatever place, for rest_distance; NULL forgets them. On the host, copied;
 *  gone when the body is updated. SOFTCD_INVALID_INPUT as softcd_scene_set_positions(), and when one is not finite. */
SOFTCD_EXPORT softcd_status softcd_scene_set_rest_positions(softcd_scene* scene, softcd_body body,
                                                            const softcd_positions* x);

/* -- Queries ------------------------------------------------------------------------------------------------------- */

/** Finds contacts between the bodies of a scene. The same input gives the same bytes, whatever the number of threads
 *  or backend. The detections of one scene run one after another. */
typedef struct softcd_query softcd_query;

/** What is compared. */
typedef uint32_t softcd_detection;
enum {
  SOFTCD_DCD = 0, /**< positions at one end of the step */
  SOFTCD_CCD = 1  /**< straight-line motion from t0 to t1 */
};

/** What is computed in, and what that promises: docs/accuracy.md. */
typedef uint32_t softcd_accuracy;
enum {
  SOFTCD_FAST = 0,         /**< float32 */
  SOFTCD_PRECISE = 1,      /**< float64 */
  SOFTCD_CONSERVATIVE = 2, /**< float64 that misses nothing within a margin, along the way either */
  /** SOFTCD_CONSERVATIVE where positions of some body are double, and in a continuous detection with margins; else
   *  SOFTCD_PRECISE */
  SOFTCD_ACCURACY_AUTOMATIC = 3
};

/** How pairs of triangles are found, none of which is ever lost. */
typedef uint32_t softcd_broad_phase;
enum {
  SOFTCD_EXACT = 0,  /**< virtual subdivision with exact control bits */
  SOFTCD_UNIFORM = 1 /**< one grid sized by the largest triangle: many more tests */
};

/** When a vertex and a triangle are in contact in a discrete detection. */
typedef uint32_t softcd_contact_rule;
enum {
  SOFTCD_DISTANCE = 0, /**< at most a margin apart */
  SOFTCD_SLAB = 1      /**< Bullet's rule for deformable bodies: at most a margin from the triangle's plane */
};

/** An end of the step. */
typedef uint32_t softcd_step_end;
enum { SOFTCD_T1 = 0, SOFTCD_T0 = 1 };

/** What is looked for. */
typedef struct softcd_query_options {
  uint32_t struct_size;             /**< sizeof of this struct */
  softcd_detection detection;       /**< SOFTCD_DCD */
  softcd_accuracy accuracy;         /**< SOFTCD_ACCURACY_AUTOMATIC */
  softcd_broad_phase broad_phase;   /**< SOFTCD_EXACT */
  softcd_contact_rule contact_rule; /**< SOFTCD_DISTANCE */
  softcd_step_end step_end;         /**< of a discrete detection: SOFTCD_T1 */
  /** 0: no triangle is split. Changes the number of tests only, not the contacts. Default: 1. */
  uint32_t subdivision;
  /** Cell size of SOFTCD_EXACT in mean bounding radii of triangles, 0.1 to 100; 0, the default, chooses one. */
  float lambda;
  /** Discrete detection only: a vertex's margin against triangles of other bodies grows by this many times the distance
   *  that it moves from t0 to t1. At least 0, the default. */
  float motion_margin;
  /** 0: every body's margin counts as 0. Default: 1. */
  uint32_t margins;
  /** A kind of feature pairs is tested between two bodies that both want it, where the query does too. Defaults: 1. */
  uint32_t vertex_triangle;
  uint32_t edge_edge; /**< see vertex_triangle */
  /** Without memory_limit: pairs of triangles are found once for several detections, as long as all stay where these
   *  were looked for. Takes memory, changes no contacts. Default: 1. */
  uint32_t reuse_pairs;
  /** Contacts stay in the memory of the scene's CUDA device, where softcd_query_wait_on_device() tells of them; for
   *  scenes with SOFTCD_BACKEND_CUDA. Default: 0. */
  uint32_t contacts_on_device;
  /** 0: neighbour_rings of bodies counts as 1 and rest_distance as 0. Default: 1. */
  uint32_t neighbour_filters;
} softcd_query_options;

/** Writes the defaults and struct_size, where `size` is sizeof(softcd_query_options). */
SOFTCD_EXPORT softcd_status softcd_query_options_init(softcd_query_options* options, uint64_t size);

/** `options` may be NULL. SOFTCD_INVALID_INPUT when an option is out of range. */
SOFTCD_EXPORT softcd_status softcd_query_create(softcd_scene* scene, const softcd_query_options* options,
                                                softcd_query** query);
/** Ends a detection that still runs. NULL is nothing to destroy. */
SOFTCD_EXPORT void softcd_query_destroy(softcd_query* query);
/** Ends a detection of the query that runs, whose contacts are lost. `options` may be NULL. */
SOFTCD_EXPORT softcd_status softcd_query_set_options(softcd_query* query, const softcd_query_options* options);

/** Called for pairs of bodies that pass groups, masks, bounding boxes and lists of pairs, and, with a == b, for bodies
 * that collide with themselves; 0 leaves the pair out of this detection. Called on the thread that starts the
 * detection, a <= b. It must not call the scene, its queries or probes, and must return: no exception, no longjmp. */
typedef uint32_t (*softcd_pair_filter)(void* user_data, softcd_body a, softcd_body b);

/** Asked by every detection from the next one on. NULL, as at first, lets all pairs through. */
SOFTCD_EXPORT softcd_status softcd_query_set_pair_filter(softcd_query* query, softcd_pair_filter filter,
                                                         void* user_data);
/** From the next detection on no other pairs are compared than these; none, as at first, excludes none. */
SOFTCD_EXPORT softcd_status softcd_query_set_only_pairs(softcd_query* query, const softcd_body_pair* pairs,
                                                        uint64_t count);

/** Which features touch. */
typedef uint8_t softcd_contact_kind;
enum { SOFTCD_VERTEX_TRIANGLE = 0, SOFTCD_EDGE_EDGE = 1 };

/** Two features in contact. Indices count within their own body. 72 bytes. */
typedef struct softcd_contact {
  softcd_contact_kind kind; /**< which features touch */
  /** 1: reported because SOFTCD_CONSERVATIVE could not tell within its bound on work; else 0. */
  uint8_t is_unsettled;
  uint16_t unused;    /**< 0 */
  softcd_body body_a; /**< the vertex's body, or the first edge's */
  softcd_body body_b; /**< the triangle's body, or the second edge's */
  /** Vertex and triangle, or the two edges: a body's edges are numbered in the order of their sorted vertex pairs. */
  uint32_t feature_a;
  uint32_t feature_b; /**< of body_b, as feature_a */
  /** The vertex, then the triangle's three; or the first edge's, lower one first, then the second's. */
  uint32_t vertices[4];
  /** Where on the features: {1, w0, w1, w2}, or {u0, u1, w0, w1}; each side sums to 1. */
  float weights[4];
  /** Unit vector from side b's point towards side a's. With SOFTCD_CCD it points to the side that a came from. */
  float normal[3];
  float distance;       /**< between the two points at time_of_impact; unit: the positions' */
  float time_of_impact; /**< in [0, 1], t0 to t1; 1 for a discrete detection */
} softcd_contact;

/** Which pairs of bodies a detection compares, of those that groups, masks, boxes and the filter leave. */
typedef uint32_t softcd_pairs;
enum {
  SOFTCD_PAIRS_ALL = 0,
  /** Those of which a body was added or updated, or given positions or settings, since the query's last detection. */
  SOFTCD_PAIRS_CHANGED = 1
};

/** Reads positions that were set and starts a detection. Bodies without positions are left out, and so is a triangle
 *  with a vertex that is not finite, with a warning. Contacts of the query's detection before are gone. */
SOFTCD_EXPORT softcd_status softcd_query_start(softcd_query* query, softcd_pairs pairs);
/** Waits for the detection that was started last, once. All contacts, sorted by (kind, body_a, feature_a, body_b,
 *  feature_b), each once, in the query's memory: valid until its next detection is started, its options are set, or it
 *  is destroyed. SOFTCD_ERROR where none was started, it was waited for already, or contacts are on the device; else
 *  what has gone wrong in the detection. */
SOFTCD_EXPORT softcd_status softcd_query_wait(softcd_query* query, const softcd_contact** contacts, uint64_t* count);

/** Contacts in a CUDA device's memory, as softcd_query_wait() would return them, and valid as long as those. */
typedef struct softcd_device_contacts {
  uint32_t struct_size;       /**< sizeof of this struct */
  int32_t device;             /**< as cudaGetDeviceCount counts them */
  const softcd_contact* data; /**< on that device */
  uint64_t count;             /**< how many there are */
  /** On that device, 2 * body_ids + 1 values: contacts [body_begin[k * body_ids + b], body_begin[k * body_ids + b + 1])
   *  are those of kind k whose body_a is b. NULL where no bodies were compared. */
  const uint64_t* body_begin;
  uint32_t body_ids; /**< all bodies' numbers are less */
} softcd_device_contacts;

/** softcd_query_wait() for a query with contacts_on_device. They are there, completely, when the call returns. Fills in
 *  *contacts, whose struct_size the caller has set. */
SOFTCD_EXPORT softcd_status softcd_query_wait_on_device(softcd_query* query, softcd_device_contacts* contacts);

/** What a detection that leaves its contacts on a device says of them there. */
typedef struct softcd_contact_counts {
  uint64_t contacts; /**< that were found: those beyond what there is room for are not there */
  /** 1: all contacts are there, in order. 0: something did not fit, or was not as foreseen; what is there is of no use,
   *  and waiting for the detection repeats it. */
  uint32_t is_complete;
  uint32_t unused; /**< 0 */
} softcd_contact_counts;

/** Contacts in a CUDA device's memory of a detection that may still run, for work that is enqueued on that device. */
typedef struct softcd_pending_contacts {
  uint32_t struct_size;       /**< sizeof of this struct */
  int32_t device;             /**< as cudaGetDeviceCount counts them */
  const softcd_contact* data; /**< on that device, once `ready` has happened */
  uint64_t capacity;          /**< how many there is room for */
  /** On that device: how many there are, and whether that is all. NULL where no bodies are compared: there are none. */
  const softcd_contact_counts* counts;
  const uint64_t* body_begin; /**< see softcd_device_contacts */
  uint32_t body_ids;          /**< see softcd_device_contacts */
  void* ready;                /**< a cudaEvent_t after which all of it is there */
} softcd_pending_contacts;

/** For a query with contacts_on_device: where the contacts of the detection that was started last will be, without
 *  waiting for them. A stream that waits for `ready` may read them; nothing else tells whether they are complete than
 *  their counts, there or after softcd_query_wait_on_device(), which repeats a detection where they are not: positions
 *  on the device have to stay as they are for that. Fills in *contacts, whose struct_size the caller has set; valid as
 *  long as what softcd_query_wait_on_device() returns. Errors are those of that. */
SOFTCD_EXPORT softcd_status softcd_query_on_device(softcd_query* query, softcd_pending_contacts* contacts);

/** softcd_query_start() and softcd_query_wait() in one. */
SOFTCD_EXPORT softcd_status softcd_query_detect(softcd_query* query, softcd_pairs pairs,
                                                const softcd_contact** contacts, uint64_t* count);

/** What the last detection that was waited for did. softcd/core/statistics.hpp tells more of each. */
typedef struct softcd_statistics {
  uint32_t struct_size;        /**< sizeof of this struct */
  softcd_backend backend;      /**< where it was computed: never SOFTCD_BACKEND_AUTOMATIC */
  uint64_t bodies;             /**< in the scene */
  uint64_t triangles;          /**< in the scene */
  uint64_t vertices;           /**< in the scene */
  uint64_t edges;              /**< in the scene */
  uint64_t active_triangles;   /**< that can reach a partner */
  uint64_t left_out_triangles; /**< with a vertex that is not finite */
  uint64_t triangle_pairs;     /**< that passed every test of the broad phase */
  uint64_t vt_candidates;      /**< vertices with triangles that were tested */
  uint64_t ee_candidates;      /**< pairs of edges that were tested */
  uint64_t vt_contacts;        /**< vertices with triangles that touch */
  uint64_t ee_contacts;        /**< pairs of edges that touch */
  uint64_t unsettled_contacts; /**< with softcd_contact::is_unsettled */
  double earliest_toi;         /**< 1 when nothing hits */
  uint64_t peak_bytes;         /**< the most of the backend's memory that was held at once */
  uint64_t reruns;             /**< stages, or detections, that were repeated as lists had to grow */
  uint64_t chunks;             /**< parts that the pairs were tested in */
  double total_ms;             /**< the detection's time, in milliseconds */
} softcd_statistics;

/** Fills in *statistics, whose struct_size the caller has set. */
SOFTCD_EXPORT softcd_status softcd_query_statistics(const softcd_query* query, softcd_statistics* statistics);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* NOLINTEND(modernize-*, readability-identifier-naming) */

/* What a scene's probes are asked. */
#include "softcd/softcd_probe.h"

#endif /* SOFTCD_SOFTCD_H */
