#include "uwsim/dynamics/broad_phase.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr double kFinestBlock_m = 1;      // about the width of a vehicle
constexpr double kMaxBlocksAlong = 4096;  // larger worlds have coarser blocks

struct Extent {
  Eigen::Vector3d low_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high_m = -low_m;
  void add(const Eigen::Vector3d& point_m) {
    low_m = low_m.cwiseMin(point_m);
    high_m = high_m.cwiseMax(point_m);
  }
};

Extent bounds(const Solid& solid) {
  Extent box;
  for (const Eigen::Vector3d& v : solid.mesh_world.vertices_m) box.add(v);
  return box;
}

/// The smallest float that is at least `value`.
float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

}  // namespace

BroadPhase::BroadPhase(const World& world) {
  set_grid(world);
  if (levels_.empty()) return;
  if (const auto& terrain = world.terrain()) raise_blocks(*terrain);
  for (const auto& solid : world.solids()) {
    const Extent box = bounds(*solid);
    raise_blocks(box.low_m, box.high_m);
  }
  while (levels_.back().nx > 1 || levels_.back().ny > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.nx + 1) / 2, (fine.ny + 1) / 2, 2 * fine.block_m, {}};
    coarse.highest_m.assign(static_cast<std::size_t>(coarse.nx * coarse.ny), -std::numeric_limits<float>::infinity());
    for (std::ptrdiff_t j = 0; j < fine.ny; ++j) {
      for (std::ptrdiff_t i = 0; i < fine.nx; ++i) {
        float& top = coarse.highest_m[static_cast<std::size_t>(j / 2 * coarse.nx + i / 2)];
        top = std::max(top, fine.highest_m[static_cast<std::size_t>(j * fine.nx + i)]);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

void BroadPhase::set_grid(const World& world) {
  Extent all;
  if (const auto& terrain = world.terrain()) {
    all.add({terrain->origin_m().x(), terrain->origin_m().y(), 0});
    all.add({terrain->far_corner_m().x(), terrain->far_corner_m().y(), 0});
  }
  for (const auto& solid : world.solids()) {
    for (const Eigen::Vector3d& v : solid->mesh_world.vertices_m) all.add(v);
  }
  if (!all.low_m.allFinite()) return;
  origin_m_ = all.low_m.head<2>();
  const Eigen::Vector2d extent = (all.high_m - all.low_m).head<2>();
  const double block = std::max(kFinestBlock_m, extent.maxCoeff() / kMaxBlocksAlong);
  Level finest{static_cast<std::ptrdiff_t>(extent.x() / block) + 1,
               static_cast<std::ptrdiff_t>(extent.y() / block) + 1,
               block,
               {}};
  finest.highest_m.assign(static_cast<std::size_t>(finest.nx * finest.ny), -std::numeric_limits<float>::infinity());
  levels_.push_back(std::move(finest));
}

/// The first and last block that an interval meets, of the grid's `count`. First > last if it lies outside the grid.
std::array<std::ptrdiff_t, 2> BroadPhase::blocks_along(double low_m, double high_m, double block_m,
                                                       std::ptrdiff_t count) {
  const auto index = [&](double along_m) {
    return static_cast<std::ptrdiff_t>(std::clamp(std::floor(along_m / block_m), -1.0, static_cast<double>(count)));
  };
  return {std::max<std::ptrdiff_t>(index(low_m), 0), std::min(index(high_m), count - 1)};
}

/// The first and last block along x, then along y.
std::array<std::ptrdiff_t, 4> BroadPhase::blocks_in(const Level& level, const Eigen::Vector2d& low_m,
                                                    const Eigen::Vector2d& high_m) const {
  const Eigen::Vector2d low = low_m - origin_m_, high = high_m - origin_m_;
  const auto [i0, i1] = blocks_along(low.x(), high.x(), level.block_m, level.nx);
  const auto [j0, j1] = blocks_along(low.y(), high.y(), level.block_m, level.ny);
  return {i0, i1, j0, j1};
}

/// Raises the blocks to the terrain: first along each row of vertices, then from each row to the blocks beside it.
void BroadPhase::raise_blocks(const Heightfield& terrain) {
  Level& level = levels_.front();
  // A vertex affects the height of the surface as far as its neighbours.
  const auto beside = [&](std::size_t vertex, int axis) {
    const double at_m = terrain.vertex(vertex)(axis);
    return blocks_along(at_m - terrain.spacing_m() - origin_m_(axis), at_m + terrain.spacing_m() - origin_m_(axis),
                        level.block_m, axis == 0 ? level.nx : level.ny);
  };
  std::vector<std::array<std::ptrdiff_t, 2>> columns;
  for (std::size_t i = 0; i < terrain.nx(); ++i) columns.push_back(beside(i, 0));
  std::vector<float> row_m(static_cast<std::size_t>(level.nx));
  for (std::size_t j = 0; j < terrain.ny(); ++j) {
    std::ranges::fill(row_m, -std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < terrain.nx(); ++i) {
      const float height_m = terrain.heights_m()[j * terrain.nx() + i];
      for (std::ptrdiff_t k = columns[i][0]; k <= columns[i][1]; ++k) {
        float& highest = row_m[static_cast<std::size_t>(k)];
        highest = std::max(highest, height_m);
      }
    }
    const auto [first, last] = beside(j * terrain.nx(), 1);
    for (std::ptrdiff_t k = first; k <= last; ++k) {
      float* const highest_m = &level.highest_m[static_cast<std::size_t>(k * level.nx)];
      for (std::size_t i = 0; i < row_m.size(); ++i) highest_m[i] = std::max(highest_m[i], row_m[i]);
    }
  }
}

void BroadPhase::raise_blocks(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) {
  Level& level = levels_.front();
  const auto [i0, i1, j0, j1] = blocks_in(level, low_world_m.head<2>(), high_world_m.head<2>());
  const float top_m = rounded_up(high_world_m.z());
  for (std::ptrdiff_t j = j0; j <= j1; ++j) {
    for (std::ptrdiff_t i = i0; i <= i1; ++i) {
      float& highest = level.highest_m[static_cast<std::size_t>(j * level.nx + i)];
      highest = std::max(highest, top_m);
    }
  }
}

bool BroadPhase::may_touch(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const {
  if (levels_.empty()) return false;
  const double width_m = (high_world_m - low_world_m).head<2>().maxCoeff();
  std::size_t k = 0;
  while (k + 1 < levels_.size() && levels_[k].block_m < width_m) ++k;
  const Level& level = levels_[k];
  const auto [i0, i1, j0, j1] = blocks_in(level, low_world_m.head<2>(), high_world_m.head<2>());
  for (std::ptrdiff_t j = j0; j <= j1; ++j) {
    for (std::ptrdiff_t i = i0; i <= i1; ++i) {
      if (level.highest_m[static_cast<std::size_t>(j * level.nx + i)] >= low_world_m.z()) return true;
    }
  }
  return false;
}

}  // namespace uwsim
