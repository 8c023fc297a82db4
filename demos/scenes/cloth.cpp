#include "scenes/cloth.hpp"

#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

struct Grid {
  int columns;
  int rows;
  bool is_closed;

  int node(int column, int row) const { return row * columns + column % columns; }
  bool has_column(int column) const { return is_closed || (column >= 0 && column < columns); }
};

void link_neighbours(btSoftBody& cloth, const Grid& grid, int column_offset, int row_offset, bool is_bending) {
  for (int row = 0; row + row_offset < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const int other = column + column_offset;
      if (!grid.has_column(other)) continue;
      cloth.appendLink(grid.node(column, row), grid.node(other + grid.columns, row + row_offset));
      if (is_bending) cloth.m_links[cloth.m_links.size() - 1].m_bbending = -1;  // the true of a signed bit
    }
  }
}

void add_faces(btSoftBody& cloth, const Grid& grid) {
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; grid.has_column(column + 1) && column < grid.columns; ++column) {
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

}  // namespace

std::unique_ptr<btSoftBody> make_cloth(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar mass) {
  const Grid grid{shape.columns, shape.rows, shape.is_closed};
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
  if (shape.resists_bending) {
    link_neighbours(*cloth, grid, 2, 0, true);
    link_neighbours(*cloth, grid, 0, 2, true);
  }
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

ClothShape vertical_tube(const btVector3& foot, btScalar radius, btScalar height, int columns, int rows) {
  ClothShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.is_closed = true;
  shape.position = [=](int column, int row) {
    const btScalar angle = SIMD_2_PI * btScalar(column) / btScalar(columns);
    return foot + btVector3(radius * btCos(angle), height * btScalar(row) / btScalar(rows - 1), radius * btSin(angle));
  };
  return shape;
}

std::unique_ptr<btSoftBody> make_ball(btSoftBodyWorldInfo& world_info, const btVector3& center, btScalar radius,
                                      int subdivisions) {
  return make_body(world_info, sphere_mesh(center, radius, subdivisions), 0);
}

}  // namespace softcd::demo
