#include "c_client.h"

#include <string.h>

typedef struct client {
  softcd_scene* scene;
  softcd_query* query;
} client;

static softcd_status add_bodies(client* self, const client_body* bodies, size_t body_count) {
  size_t i;
  for (i = 0; i < body_count; ++i) {
    const client_body* body = &bodies[i];
    softcd_body id;
    softcd_status status = softcd_scene_add_body(self->scene, body->triangles, body->triangle_count, body->vertex_count,
                                                 &body->settings, &id);
    if (status == SOFTCD_OK) status = softcd_scene_set_positions(self->scene, id, &body->x_t0, &body->x_t1);
    if (status != SOFTCD_OK) return status;
  }
  return SOFTCD_OK;
}

static softcd_status detect_twice(client* self, softcd_contact* contacts, uint64_t capacity, uint64_t* count) {
  const softcd_contact* found;
  uint64_t found_count;
  softcd_status status = softcd_query_start(self->query, SOFTCD_PAIRS_ALL);
  if (status == SOFTCD_OK) status = softcd_query_wait(self->query, &found, count);
  if (status != SOFTCD_OK) return status;
  if (*count > capacity) return SOFTCD_ERROR;
  memcpy(contacts, found, (size_t)*count * sizeof *contacts);
  status = softcd_query_detect(self->query, SOFTCD_PAIRS_ALL, &found, &found_count);
  if (status != SOFTCD_OK) return status;
  if (found_count != *count || memcmp(contacts, found, (size_t)*count * sizeof *contacts) != 0) return SOFTCD_ERROR;
  return SOFTCD_OK;
}

softcd_status client_detect(const client_body* bodies, size_t body_count, const softcd_scene_options* scene_options,
                            const softcd_query_options* query_options, softcd_contact* contacts, uint64_t capacity,
                            uint64_t* count) {
  client self = {NULL, NULL};
  softcd_status status = softcd_scene_create(scene_options, &self.scene);
  if (status == SOFTCD_OK) status = add_bodies(&self, bodies, body_count);
  if (status == SOFTCD_OK) status = softcd_query_create(self.scene, query_options, &self.query);
  if (status == SOFTCD_OK) status = detect_twice(&self, contacts, capacity, count);
  softcd_query_destroy(self.query);
  softcd_scene_destroy(self.scene);
  return status;
}

size_t client_struct_sizes(size_t* sizes, size_t capacity) {
#define SIZE_OF(type) sizeof(type),
  const size_t here[] = {SOFTCD_CLIENT_STRUCTS(SIZE_OF)};
#undef SIZE_OF
  const size_t count = sizeof here / sizeof here[0];
  if (count <= capacity) memcpy(sizes, here, sizeof here);
  return count;
}
