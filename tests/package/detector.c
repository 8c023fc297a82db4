#include <softcd/softcd.h>
#include <stdio.h>
#include <string.h>

/* One vertex of the second triangle lies 0.1 above the first triangle. */
static softcd_status detect(softcd_scene* scene, softcd_query* query, uint64_t* count) {
  static const uint32_t triangle[] = {0, 1, 2};
  static const float x[2][9] = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0.25f, 0.25f, 0.1f, 0.25f, 0.5f, 5, 0.5f, 0.25f, 5}};
  const softcd_contact* contacts;
  softcd_body_settings settings;
  softcd_status status = softcd_body_settings_init(&settings, sizeof settings);
  int i;
  settings.margin = 0.1f;
  for (i = 0; i < 2 && status == SOFTCD_OK; ++i) {
    const softcd_positions positions = {sizeof positions, SOFTCD_FLOAT32, SOFTCD_HOST, x[i], 3, 12, NULL};
    softcd_body body;
    status = softcd_scene_add_body(scene, triangle, 1, 3, &settings, &body);
    if (status == SOFTCD_OK) status = softcd_scene_set_positions(scene, body, NULL, &positions);
  }
  return status == SOFTCD_OK ? softcd_query_detect(query, SOFTCD_PAIRS_ALL, &contacts, count) : status;
}

/* Its argument is the version that the package says it has. */
int main(int count, char** arguments) {
  const int has_version =
      count == 2 && strcmp(arguments[1], SOFTCD_VERSION_STRING) == 0 && softcd_version() == SOFTCD_VERSION;
  softcd_scene* scene = NULL;
  softcd_query* query = NULL;
  uint64_t contacts = 0;
  softcd_status status = softcd_scene_create(NULL, &scene);
  if (status == SOFTCD_OK) status = softcd_query_create(scene, NULL, &query);
  if (status == SOFTCD_OK) status = detect(scene, query, &contacts);
  if (status != SOFTCD_OK) fprintf(stderr, "%s\n", softcd_last_error());
  softcd_query_destroy(query);
  softcd_scene_destroy(scene);
  return has_version && status == SOFTCD_OK && contacts == 1 ? 0 : 1;
}
