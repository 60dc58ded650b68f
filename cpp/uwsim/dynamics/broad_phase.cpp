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
  if (const auto& terrain = world.terrain()) {
    // A vertex affects the height of the surface as far as its neighbours.
    const Eigen::Vector3d around(terrain->spacing_m(), terrain->spacing_m(), 0);
    for (std::size_t k = 0; k < terrain->heights_m().size(); ++k) {
      const Eigen::Vector3d v = terrain->vertex(k);
      raise_blocks(v - around, v + around);
    }
  }
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

/// The first and last block along x, then along y. First > last if the box is outside the grid.
std::array<std::ptrdiff_t, 4> BroadPhase::blocks_in(const Level& level, const Eigen::Vector2d& low_m,
                                                    const Eigen::Vector2d& high_m) const {
  const auto index = [&](double along_m, std::ptrdiff_t count) {
    return static_cast<std::ptrdiff_t>(
        std::clamp(std::floor(along_m / level.block_m), -1.0, static_cast<double>(count)));
  };
  const Eigen::Vector2d low = low_m - origin_m_, high = high_m - origin_m_;
  return {std::max<std::ptrdiff_t>(index(low.x(), level.nx), 0), std::min(index(high.x(), level.nx), level.nx - 1),
          std::max<std::ptrdiff_t>(index(low.y(), level.ny), 0), std::min(index(high.y(), level.ny), level.ny - 1)};
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
