#include "scenes/cloth.hpp"

#include <array>
#include <map>
#include <utility>

namespace softcd::demo {
namespace {

struct Grid {
  int columns;
  int rows;

  int node(int column, int row) const { return row * columns + column; }
};

void link_neighbours(btSoftBody& cloth, const Grid& grid, int column_offset, int row_offset, bool is_bending) {
  for (int row = 0; row + row_offset < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const int other = column + column_offset;
      if (other < 0 || other >= grid.columns) continue;
      cloth.appendLink(grid.node(column, row), grid.node(other, row + row_offset));
      if (is_bending) cloth.m_links[cloth.m_links.size() - 1].m_bbending = -1;  // the true of a signed bit
    }
  }
}

void add_faces(btSoftBody& cloth, const Grid& grid) {
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const int a = grid.node(column, row);
      const int b = grid.node(column + 1, row);
      const int c = grid.node(column + 1, row + 1);
      const int d = grid.node(column, row + 1);
      if ((column + row) % 2 == 0) {
        cloth.appendFace(a, c, b);
        cloth.appendFace(a, d, c);
      } else {
        cloth.appendFace(a, d, b);
        cloth.appendFace(b, d, c);
      }
    }
  }
}

struct SphereMesh {
  std::vector<btVector3> directions;
  std::vector<std::array<int, 3>> triangles;
};

SphereMesh icosahedron() {
  const btScalar g = (1 + btSqrt(btScalar(5))) / 2;
  SphereMesh mesh;
  mesh.directions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                     {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (btVector3& direction : mesh.directions) direction.normalize();
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

SphereMesh subdivided(const SphereMesh& coarse) {
  SphereMesh fine;
  fine.directions = coarse.directions;
  std::map<std::pair<int, int>, int> midpoints;
  const auto midpoint = [&](int a, int b) {
    const auto [entry, is_new] = midpoints.try_emplace(std::minmax(a, b), static_cast<int>(fine.directions.size()));
    if (is_new) {
      const btVector3 sum = fine.directions[static_cast<std::size_t>(a)] + fine.directions[static_cast<std::size_t>(b)];
      fine.directions.push_back(sum.normalized());
    }
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const int ab = midpoint(a, b);
    const int bc = midpoint(b, c);
    const int ca = midpoint(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace

std::unique_ptr<btSoftBody> make_cloth(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar mass) {
  const Grid grid{shape.columns, shape.rows};
  std::vector<btVector3> positions;
  std::vector<btScalar> masses;
  for (int row = 0; row < shape.rows; ++row) {
    for (int column = 0; column < shape.columns; ++column) {
      positions.push_back(shape.position(column, row));
      masses.push_back(1);
    }
  }
  auto cloth =
      std::make_unique<btSoftBody>(&world_info, static_cast<int>(positions.size()), positions.data(), masses.data());
  link_neighbours(*cloth, grid, 1, 0, false);
  link_neighbours(*cloth, grid, 0, 1, false);
  link_neighbours(*cloth, grid, 1, 1, false);
  link_neighbours(*cloth, grid, -1, 1, false);
  link_neighbours(*cloth, grid, 2, 0, true);
  link_neighbours(*cloth, grid, 0, 2, true);
  add_faces(*cloth, grid);
  cloth->setTotalMass(mass);
  if (shape.is_fixed) {
    for (int row = 0; row < shape.rows; ++row) {
      for (int column = 0; column < shape.columns; ++column) {
        if (shape.is_fixed(column, row)) cloth->setMass(grid.node(column, row), 0);
      }
    }
  }
  cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  return cloth;
}

ClothShape horizontal_cloth(int nodes_per_side, btScalar side, btScalar height) {
  const btScalar spacing = side / btScalar(nodes_per_side - 1);
  ClothShape shape;
  shape.columns = nodes_per_side;
  shape.rows = nodes_per_side;
  shape.position = [=](int column, int row) {
    return btVector3(btScalar(column) * spacing - side / 2, height, btScalar(row) * spacing - side / 2);
  };
  return shape;
}

std::unique_ptr<btSoftBody> make_ball(btSoftBodyWorldInfo& world_info, const btVector3& center, btScalar radius,
                                      int subdivisions) {
  SphereMesh mesh = icosahedron();
  for (int i = 0; i < subdivisions; ++i) mesh = subdivided(mesh);
  std::vector<btVector3> positions;
  for (const btVector3& direction : mesh.directions) positions.push_back(center + radius * direction);
  const std::vector<btScalar> masses(positions.size(), 0);
  auto ball =
      std::make_unique<btSoftBody>(&world_info, static_cast<int>(positions.size()), positions.data(), masses.data());
  for (const auto& [a, b, c] : mesh.triangles) {
    ball->appendFace(a, b, c);
    // Each edge once: the neighbour runs through it the other way. Bullet's tree builder does not end on nodes that
    // links do not join.
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      if (from < to) ball->appendLink(from, to);
    }
  }
  ball->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  return ball;
}

}  // namespace softcd::demo
