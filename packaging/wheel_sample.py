"""What a wheel must do where it is installed. packaging/wheel_sample.txt has what it prints."""

import numpy as np

import softcd

table = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], np.float32)
sheet = np.array([[1, 1, 1], [2, 1, 1.5], [2, 2, 2], [1, 2, 1.5]], np.float32)
square = np.array([[0, 1, 2], [0, 2, 3]])
vertices_t0, triangles = np.concatenate([table, sheet]), np.concatenate([square, square + 4])
vertices_t1 = vertices_t0 - np.float32([0, 0, 2]) * (np.arange(8) > 3)[:, None]  # the sheet falls through the table

for contact in softcd.detect(vertices_t0, triangles, vertices_t1):
    print(contact["kind"], contact["vertices"], contact["normal"], contact["time_of_impact"])
print(softcd.collision_free_step(vertices_t0, triangles, vertices_t1))
print(softcd.self_intersections(vertices_t1, triangles).tolist())
