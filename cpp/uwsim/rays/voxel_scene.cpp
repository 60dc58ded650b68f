#include "uwsim/rays/voxel_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"

namespace uwsim {
namespace {

constexpr int kStartsInside = 3;  // stands for the axis across which a ray enters a cube, if it starts inside

/// The normal along an axis that points against the ray.
Eigen::Vector3f normal_against(const Eigen::Vector3d& direction, int axis) {
  if (axis == kStartsInside) direction.cwiseAbs().maxCoeff(&axis);
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  normal[axis] = direction[axis] > 0 ? -1.0F : 1.0F;
  return normal;
}

}  // namespace

/// A ray whose position is in units of cubes from the lowest corner; distances along the ray remain in metres.
struct VoxelScene::Walk {
  Eigen::Vector3d start, rate;

  double at(int axis, double distance_m) const { return start[axis] + rate[axis] * distance_m; }

  /// Visits, in order, the square cells, with an edge of `size` cubes, that the ray crosses between two distances,
  /// until visit(i, j, from, to, axis) returns true. The last argument of visit is the axis across which the ray enters
  /// the cell; for the first cell, it is `axis`. low and high bound the cell indices, since rounding may place the ray
  /// just outside the grid.
  template <typename Visit>
  bool cells(double size, std::array<std::int32_t, 2> low, std::array<std::int32_t, 2> high, double from, double to,
             int axis, const Visit& visit) const {
    std::array<std::int32_t, 2> cell{}, step{};
    std::array<double, 2> next{}, width{};
    for (int k = 0; k < 2; ++k) {
      cell[k] = static_cast<std::int32_t>(std::clamp(std::floor(at(k, from) / size), double(low[k]), double(high[k])));
      step[k] = rate[k] > 0 ? 1 : -1;
      width[k] = rate[k] == 0 ? kInfinity : size / std::abs(rate[k]);
      next[k] = rate[k] == 0 ? kInfinity : ((cell[k] + (rate[k] > 0 ? 1 : 0)) * size - start[k]) / rate[k];
    }
    for (;;) {
      const int k = next[0] < next[1] ? 0 : 1;
      if (visit(cell[0], cell[1], from, std::min(next[k], to), axis)) return true;
      if (next[k] >= to) return false;
      from = next[k], axis = k;
      next[k] += width[k], cell[k] += step[k];
      if (cell[k] < low[k] || cell[k] > high[k]) return false;
    }
  }
};

VoxelScene::VoxelScene(std::span<const Eigen::Vector3d> centres_world_m, double edge_m) : edge_m_(edge_m) {
  require(std::isfinite(edge_m) && edge_m > 0, "edge_m", edge_m, "must be positive");
  if (centres_world_m.empty()) return;
  Eigen::Array3d low = centres_world_m[0].array(), high = low;
  for (const Eigen::Vector3d& centre : centres_world_m) low = low.min(centre.array()), high = high.max(centre.array());
  const bool fits = low.isFinite().all() && high.isFinite().all() && ((high - low) / edge_m < 1 << 17).all() &&
                    ((low.abs().max(high.abs())) / edge_m < 1 << 30).all();
  require(fits, "centres_world_m", (high - low).transpose(), "must be finite, and less than 2^17 cubes apart");
  for (int k = 0; k < 3; ++k) {
    low_[k] = static_cast<std::int32_t>(std::floor(low[k] / edge_m));
    high_[k] = static_cast<std::int32_t>(std::floor(high[k] / edge_m));
  }
  for (int k = 0; k < 2; ++k) block_counts_[k] = (high_[k] - low_[k]) / kBlock + 1;

  // One number per cube; sorting the numbers sorts the cubes by block, then by column, then by height.
  std::vector<std::uint64_t> cubes;
  cubes.reserve(centres_world_m.size());
  for (const Eigen::Vector3d& centre : centres_world_m) {
    std::array<std::uint64_t, 3> at{};
    for (int k = 0; k < 3; ++k) {
      at[k] = static_cast<std::uint64_t>(static_cast<std::int32_t>(std::floor(centre[k] / edge_m)) - low_[k]);
    }
    const std::uint64_t block = (at[1] / kBlock) * static_cast<std::uint64_t>(block_counts_[0]) + at[0] / kBlock;
    const std::uint64_t column = (at[1] % kBlock) * kBlock + at[0] % kBlock;
    cubes.push_back(block << 31 | column << 21 | at[2]);
  }
  std::ranges::sort(cubes);
  const auto repeated = std::ranges::unique(cubes);
  cubes.erase(repeated.begin(), repeated.end());

  block_numbers_.assign(static_cast<std::size_t>(block_counts_[0]) * static_cast<std::size_t>(block_counts_[1]), -1);
  heights_.reserve(cubes.size());
  for (std::size_t k = 0; k < cubes.size();) {
    const std::uint64_t number = cubes[k] >> 31;
    block_numbers_[number] = static_cast<std::int32_t>(blocks_.size());
    Block& block = blocks_.emplace_back();
    block.low = std::numeric_limits<std::int32_t>::max();
    for (std::size_t column = 0; column < kBlock * kBlock; ++column) {
      block.first[column] = static_cast<std::uint32_t>(heights_.size());
      for (; k < cubes.size() && cubes[k] >> 21 == (number << 10 | column); ++k) {
        heights_.push_back(static_cast<std::int32_t>(cubes[k] & ((1U << 21) - 1)));
        block.low = std::min(block.low, heights_.back());
        block.high = std::max(block.high, heights_.back());
      }
    }
    block.first.back() = static_cast<std::uint32_t>(heights_.size());
  }
}

const VoxelScene::Block* VoxelScene::block_at(std::int32_t i, std::int32_t j) const {
  const std::int32_t number = block_numbers_[static_cast<std::size_t>(j) * static_cast<std::size_t>(block_counts_[0]) +
                                             static_cast<std::size_t>(i)];
  return number < 0 ? nullptr : &blocks_[static_cast<std::size_t>(number)];
}

RayHit VoxelScene::cast(const Ray& ray, double max_range_m) const {
  RayHit hit{kInfinity, Eigen::Vector3f::Zero(), 0};
  if (blocks_.empty()) return hit;
  Walk walk{ray.origin_world_m / edge_m_, ray.direction_world / edge_m_};
  for (int k = 0; k < 3; ++k) walk.start[k] -= low_[k];

  double from = 0, to = max_range_m;
  int axis = kStartsInside;
  for (int k = 0; k < 3; ++k) {
    const double size = high_[k] - low_[k] + 1;
    if (walk.rate[k] == 0) {
      if (walk.start[k] < 0 || walk.start[k] > size) return hit;
      continue;
    }
    const double one = -walk.start[k] / walk.rate[k], other = (size - walk.start[k]) / walk.rate[k];
    if (std::min(one, other) > from) from = std::min(one, other), axis = k;
    to = std::min(to, std::max(one, other));
  }
  if (!(from <= to)) return hit;
  walk.cells(kBlock, {0, 0}, {block_counts_[0] - 1, block_counts_[1] - 1}, from, to, axis,
             [&](std::int32_t i, std::int32_t j, double enter, double leave, int across) {
               const Block* block = block_at(i, j);
               if (block == nullptr) return false;
               const auto [lower, upper] = std::minmax({walk.at(2, enter), walk.at(2, leave)});
               if (upper < block->low || lower > block->high + 1) return false;
               return meet_block(walk, *block, i, j, enter, leave, across, hit);
             });
  return hit;
}

bool VoxelScene::meet_block(const Walk& walk, const Block& block, std::int32_t i, std::int32_t j, double from,
                            double to, int axis, RayHit& hit) const {
  const std::array<std::int32_t, 2> low{i * kBlock, j * kBlock}, high{low[0] + kBlock - 1, low[1] + kBlock - 1};
  return walk.cells(1, low, high, from, to, axis,
                    [&](std::int32_t column, std::int32_t row, double enter, double leave, int across) {
                      const auto k = static_cast<std::size_t>((row - low[1]) * kBlock + (column - low[0]));
                      const std::span heights(&heights_[0] + block.first[k], block.first[k + 1] - block.first[k]);
                      return !heights.empty() && meet_column(walk, heights, enter, leave, across, hit);
                    });
}

bool VoxelScene::meet_column(const Walk& walk, std::span<const std::int32_t> heights, double from, double to, int axis,
                             RayHit& hit) const {
  const double rate = walk.rate.z(), entry = walk.at(2, from);
  const auto met = [&](double distance_m, int across) {
    hit = {distance_m, normal_against(walk.rate, across), 0};
    return true;
  };
  if (rate <= 0) {
    for (std::size_t k = heights.size(); k-- > 0;) {
      if (heights[k] > entry) continue;
      if (entry < heights[k] + 1) return met(from, axis);
      const double distance_m = (heights[k] + 1 - walk.start.z()) / rate;
      return rate < 0 && distance_m <= to && met(std::max(distance_m, from), 2);
    }
    return false;
  }
  for (const std::int32_t height : heights) {
    if (height + 1 < entry) continue;
    if (height <= entry) return met(from, axis);
    const double distance_m = (height - walk.start.z()) / rate;
    return distance_m <= to && met(distance_m, 2);
  }
  return false;
}

}  // namespace uwsim
