#include "uwsim/mapping/map_queries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

bool on_lattice(const VoxelKey& corner, int levels) {
  const int mask = (1 << levels) - 1;
  return ((corner[0] | corner[1] | corner[2]) & mask) == 0;
}

/// Whether the last eight are the eighths of one cube, all equal.
bool are_one(const std::vector<MapCube>& leaves) {
  if (leaves.size() < 8) return false;
  const MapCube& first = leaves[leaves.size() - 8];
  if (first.levels + 1 >= kTreeDepth || !on_lattice(first.corner, first.levels + 1)) return false;
  for (std::size_t i = leaves.size() - 7; i < leaves.size(); ++i) {
    if (leaves[i].levels != first.levels || leaves[i].log_odds != first.log_odds) return false;
  }
  // In Morton order the last eighth is in its place only if all are.
  const int half = 1 << first.levels;
  const VoxelKey& last = leaves.back().corner;
  return last == VoxelKey{first.corner[0] + half, first.corner[1] + half, first.corner[2] + half};
}

void visit_within(const MapCube& cube, const KeyBox& box, const CubeVisitor& visit) {
  if (!box.meets(cube.corner, cube.levels)) return;
  if (cube.levels == 0) return visit(cube);
  const int half = 1 << (cube.levels - 1);
  for (int child = 0; child < 8; ++child) {
    visit_within({{cube.corner[0] + (child & 1) * half, cube.corner[1] + (child >> 1 & 1) * half,
                   cube.corner[2] + (child >> 2 & 1) * half},
                  cube.levels - 1,
                  cube.log_odds},
                 box, visit);
  }
}

void visit_cells(const MapCube& cube, int levels, const CubeVisitor& visit) {
  if (cube.levels == levels) return visit(cube);
  const int half = 1 << (cube.levels - 1);
  for (int child = 0; child < 8; ++child) {
    visit_cells({{cube.corner[0] + (child & 1) * half, cube.corner[1] + (child >> 1 & 1) * half,
                  cube.corner[2] + (child >> 2 & 1) * half},
                 cube.levels - 1,
                 cube.log_odds},
                levels, visit);
  }
}

}  // namespace

void for_each_pruned_leaf(const MapEngine& engine, const CubeVisitor& visit) {
  std::vector<MapCube> waiting;  // what may still become part of a larger one
  const auto give = [&](std::size_t keep) {
    for (std::size_t i = 0; i + keep < waiting.size(); ++i) visit(waiting[i]);
    waiting.erase(waiting.begin(), waiting.end() - static_cast<std::ptrdiff_t>(keep));
  };
  engine.for_each_leaf([&](const VoxelKey& corner, int levels, float log_odds) {
    waiting.push_back({corner, levels, log_odds});
    while (are_one(waiting)) {
      const MapCube first = waiting[waiting.size() - 8];
      waiting.resize(waiting.size() - 8);
      waiting.push_back({first.corner, first.levels + 1, first.log_odds});
    }
    // Of each level at most seven wait for an eighth, all of one value and one behind the other.
    if (waiting.size() > 4096) give(7 * kTreeDepth);
  });
  give(0);
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
    const VoxelKey of{corner[0] & mask, corner[1] & mask, corner[2] & mask};
    if (any && cell.corner == of) {
      cell.log_odds = std::max(cell.log_odds, log_odds);
      return;
    }
    finish();
    cell = {of, levels, log_odds};
    any = true;
  });
  finish();
}

void for_each_voxel_in(const MapEngine& engine, const KeyBox& box, const CubeVisitor& visit) {
  engine.for_each_leaf_in(box, [&](const VoxelKey& corner, int levels, float log_odds) {
    visit_within({corner, levels, log_odds}, box, visit);
  });
}

RayCast cast_ray(const MapEngine& engine, double resolution_m, const Eigen::Vector3f& origin_m,
                 const Eigen::Vector3f& direction, bool ignore_unknown, double max_range_m) {
  constexpr double kFar = std::numeric_limits<double>::max();
  VoxelKey key;
  std::array<int, 3> step;
  std::array<double, 3> next, stride;
  const auto centre = [&](int k) { return (static_cast<double>(k - kHalfExtent) + 0.5) * resolution_m; };
  const auto voxel_m = [&] {
    return Eigen::Vector3d(centre(key[0]), centre(key[1]), centre(key[2])).cast<float>().eval();
  };
  for (std::size_t i = 0; i < 3; ++i) {
    key[i] =
        static_cast<int>(std::floor(1.0 / resolution_m * static_cast<double>(origin_m[Eigen::Index(i)]))) + kHalfExtent;
  }
  if (const std::optional<float> here = engine.log_odds_at(key)) {
    if (OccupancyModel::is_occupied(*here)) return {RayEnd::hit, key};
  } else if (!ignore_unknown) {
    return {RayEnd::unknown, key};
  }
  const float x = direction.x(), y = direction.y(), z = direction.z();
  const auto length = static_cast<float>(std::sqrt(static_cast<double>(x * x + y * y + z * z)));
  for (std::size_t i = 0; i < 3; ++i) {
    const float along = length > 0 ? direction[Eigen::Index(i)] / length : direction[Eigen::Index(i)];
    step[i] = (along > 0) - (along < 0);
    const double border = centre(key[i]) + step[i] * resolution_m * 0.5;
    const bool moves = step[i] != 0;
    next[i] = moves ? (border - static_cast<double>(origin_m[Eigen::Index(i)])) / static_cast<double>(along) : kFar;
    stride[i] = moves ? resolution_m / std::abs(static_cast<double>(along)) : kFar;
  }
  for (;;) {
    const std::size_t axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const int beyond = key[axis] + step[axis];
    if (step[axis] == 0 || beyond < 0 || beyond >= 2 * kHalfExtent) return {RayEnd::free, key};
    key[axis] = beyond;
    next[axis] += stride[axis];
    const Eigen::Vector3f end_m = voxel_m();
    if (max_range_m > 0) {
      double square = 0;
      for (Eigen::Index i = 0; i < 3; ++i)
        square += static_cast<double>((end_m[i] - origin_m[i]) * (end_m[i] - origin_m[i]));
      if (square > max_range_m * max_range_m) return {RayEnd::free, key};
    }
    const std::optional<float> log_odds = engine.log_odds_at(key);
    if (log_odds && OccupancyModel::is_occupied(*log_odds)) return {RayEnd::hit, key};
    if (!log_odds && !ignore_unknown) return {RayEnd::unknown, key};
  }
}

}  // namespace uwsim
