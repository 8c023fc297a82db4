// One scene on several processes, which MPI has started. Each process sets the positions of its own sheet and finds the
// contacts in its part of the space, and receives all contacts. With NCCL and one GPU for each process, only the
// communicator is made differently: softcd::Communicator::of_nccl.

#include <mpi.h>
#include <softcd/softcd.hpp>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

constexpr std::uint32_t kSide = 60;

/// Returns the sheet's vertices at a time: it lies at height 0.02 times `number`, and waves.
std::vector<softcd::Vec3f> sheet_at(int number, float time) {
  std::vector<softcd::Vec3f> x;
  for (std::uint32_t row = 0; row < kSide; ++row) {
    for (std::uint32_t column = 0; column < kSide; ++column) {
      const float u = 0.05F * static_cast<float>(column);
      const float v = 0.05F * static_cast<float>(row);
      const float phase = 3.0F * u + 2.0F * v + time + static_cast<float>(number);
      x.push_back({u, v, 0.02F * static_cast<float>(number) + 0.03F * std::sin(phase)});
    }
  }
  return x;
}

std::vector<softcd::Triangle> sheet_triangles() {
  std::vector<softcd::Triangle> triangles;
  for (std::uint32_t row = 0; row + 1 < kSide; ++row) {
    for (std::uint32_t column = 0; column + 1 < kSide; ++column) {
      const std::uint32_t i = row * kSide + column;
      triangles.push_back({{i, i + 1, i + kSide}});
      triangles.push_back({{i + 1, i + kSide + 1, i + kSide}});
    }
  }
  return triangles;
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);

  softcd::SceneOptions options;
  options.backend = softcd::Backend::cpu;
  options.communicator = softcd::Communicator(rank, size, [](const void* mine, std::size_t bytes, void* all) {
    const int count = static_cast<int>(bytes);
    if (MPI_Allgather(mine, count, MPI_BYTE, all, count, MPI_BYTE, MPI_COMM_WORLD) != MPI_SUCCESS) {
      throw std::runtime_error("MPI_Allgather has failed");
    }
  });
  softcd::Scene scene(options);
  const std::vector<softcd::Triangle> triangles = sheet_triangles();
  softcd::BodySettings settings;
  settings.margin = 0.01F;
  std::vector<softcd::BodyId> sheets;
  sheets.reserve(static_cast<std::size_t>(size));
  for (int owner = 0; owner < size; ++owner) {
    sheets.push_back(scene.add_body({triangles, kSide * kSide, settings, owner}));
  }
  softcd::Query query(scene);
  for (int step = 0; step < 3; ++step) {
    const std::vector<softcd::Vec3f> x = sheet_at(rank, 0.3F * static_cast<float>(step));
    scene.set_positions(sheets[static_cast<std::size_t>(rank)], x);
    const std::size_t found = query.detect().size();
    const std::size_t of_all = query.gather_contacts().size();
    std::printf("step %d: rank %d has found %zu of %zu contacts\n", step, rank, found, of_all);
  }
  MPI_Finalize();
  return 0;
}
