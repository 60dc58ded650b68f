#include "uwsim/mapping/map_cubes.h"

#include <algorithm>
#include <vector>

namespace uwsim {
namespace {

bool is_on_lattice(const VoxelKey& corner, int levels) {
  const int mask = (1 << levels) - 1;
  return ((corner[0] | corner[1] | corner[2]) & mask) == 0;
}

/// Whether the last eight leaves are the eighths of one cube and have the same value.
bool can_be_pruned(const std::vector<MapCube>& leaves) {
  if (leaves.size() < 8) return false;
  const MapCube& first = leaves[leaves.size() - 8];
  if (first.levels + 1 >= kTreeDepth || !is_on_lattice(first.corner, first.levels + 1)) return false;
  for (std::size_t i = leaves.size() - 7; i < leaves.size(); ++i) {
    if (leaves[i].levels != first.levels || leaves[i].log_odds != first.log_odds) return false;
  }
  // Leaves are in Morton order, so if the last one is in the position of the last eighth, all are in their positions.
  return leaves.back().corner == child_corner(first.corner, 7, 1 << first.levels);
}

MapCube child_of(const MapCube& cube, int i) {
  return {child_corner(cube.corner, i, 1 << (cube.levels - 1)), cube.levels - 1, cube.log_odds};
}

void visit_voxels_in(const MapCube& cube, const KeyBox& box, const CubeVisitor& visit) {
  if (!box.meets(cube.corner, cube.levels)) return;
  if (cube.levels == 0) return visit(cube);
  for (int i = 0; i < 8; ++i) visit_voxels_in(child_of(cube, i), box, visit);
}

void visit_cells(const MapCube& cube, int levels, const CubeVisitor& visit) {
  if (cube.levels == levels) return visit(cube);
  for (int i = 0; i < 8; ++i) visit_cells(child_of(cube, i), levels, visit);
}

}  // namespace

void for_each_pruned_leaf(const MapEngine& engine, const CubeVisitor& visit) {
  std::vector<MapCube> waiting;  // leaves that may still become part of a larger one
  const auto visit_all_but = [&](std::size_t keep) {
    for (std::size_t i = 0; i + keep < waiting.size(); ++i) visit(waiting[i]);
    waiting.erase(waiting.begin(), waiting.end() - static_cast<std::ptrdiff_t>(keep));
  };
  engine.for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
    waiting.push_back({corner, levels, log_odds});
    while (can_be_pruned(waiting)) {
      const MapCube first = waiting[waiting.size() - 8];
      waiting.resize(waiting.size() - 8);
      waiting.push_back({first.corner, first.levels + 1, first.log_odds});
    }
    // At each level, at most seven leaves can still be waiting for an eighth, and they are the last ones.
    if (waiting.size() > 4096) visit_all_but(7 * kTreeDepth);
  });
  visit_all_but(0);
}

void for_each_cell(const MapEngine& engine, int levels, const CubeVisitor& visit) {
  const int mask = ~((1 << levels) - 1);
  bool any = false;
  MapCube cell{};
  const auto finish = [&] {
    if (any) visit(cell);
    any = false;
  };
  engine.for_each_leaf([&](const VoxelKey& corner, int leaf_levels, float log_odds) {
    if (leaf_levels >= levels) {
      finish();
      return visit_cells({corner, leaf_levels, log_odds}, levels, visit);
    }
    const VoxelKey cell_corner{corner[0] & mask, corner[1] & mask, corner[2] & mask};
    if (any && cell.corner == cell_corner) {
      cell.log_odds = std::max(cell.log_odds, log_odds);
      return;
    }
    finish();
    cell = {cell_corner, levels, log_odds};
    any = true;
  });
  finish();
}

void for_each_voxel_in(const MapEngine& engine, const KeyBox& box, const CubeVisitor& visit) {
  engine.for_each_leaf_in(box, [&](const VoxelKey& corner, int levels, float log_odds) {
    visit_voxels_in({corner, levels, log_odds}, box, visit);
  });
}

}  // namespace uwsim
