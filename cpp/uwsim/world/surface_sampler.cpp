#include "uwsim/world/surface_sampler.h"

#include <bit>
#include <cmath>
#include <utility>

#include "uwsim/world/sampled_triangle.h"

namespace uwsim {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

constexpr double kRounding = 0.01;  // in voxels; boxes are enlarged by this

Eigen::AlignedBox3d box_around(const Corners& corners) {
  Eigen::AlignedBox3d box(corners[0]);
  return box.extend(corners[1]).extend(corners[2]);
}

/// The range of terrain cells near a box along an axis: the first cell, and one past the last.
std::pair<std::size_t, std::size_t> cells_near(const Heightfield& terrain, const Eigen::AlignedBox3d& box_m, int axis,
                                               std::size_t cells) {
  const auto cell = [&](double x, int more) {
    const double at = std::floor((x - terrain.origin_m()[axis]) / terrain.spacing_m()) + more;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(cells)));
  };
  return {cell(box_m.min()[axis], -1), cell(box_m.max()[axis], 2)};
}

/// The octants of a block of voxels, one bit each: set if occupied. The eight bits of each voxel form one byte.
class Octants {
 public:
  Octants(const GridCell& first, const GridCell& end) : first_(first) {
    for (std::size_t axis = 0; axis < 3; ++axis) size_[axis] = std::max(end[axis] - first[axis], std::int64_t{0});
    taken_.resize(static_cast<std::size_t>((size_[0] * size_[1] * size_[2] + 7) / 8), 0);
  }

  /// The index of the octant with these coordinates, in half voxel edges; -1 outside the block.
  std::int64_t number(const Eigen::Vector3d& halves) const {
    std::array<std::int64_t, 3> at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = static_cast<std::int64_t>(std::floor(halves[Eigen::Index(axis)])) - 2 * first_[axis];
      if (at[axis] < 0 || at[axis] >= 2 * size_[axis]) return -1;
    }
    const std::int64_t voxel = ((at[0] >> 1) * size_[1] + (at[1] >> 1)) * size_[2] + (at[2] >> 1);
    return voxel << 3 | (at[0] & 1) << 2 | (at[1] & 1) << 1 | (at[2] & 1);
  }
  bool is_taken(std::int64_t number) const { return (taken_[word(number)] & bit(number)) != 0; }
  void take(std::int64_t number) { taken_[word(number)] |= bit(number); }

  /// Returns, for each word of 64 octants, the number of occupied octants before it.
  std::vector<std::uint32_t> counts_before() const {
    std::vector<std::uint32_t> before(taken_.size());
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < taken_.size(); ++k) {
      before[k] = count;
      if (taken_[k] != 0) count += static_cast<std::uint32_t>(std::popcount(taken_[k]));
    }
    return before;
  }
  /// The number of occupied octants before this one.
  std::size_t rank(std::int64_t number, const std::vector<std::uint32_t>& before) const {
    const std::uint64_t lower = taken_[word(number)] & (bit(number) - 1);
    return before[word(number)] + static_cast<std::size_t>(std::popcount(lower));
  }

  /// Calls visit(voxel, occupied octants) for each voxel that has occupied octants, in order.
  template <typename Visit>
  void visit_voxels(const Visit& visit) const {
    for (std::size_t k = 0; k < taken_.size(); ++k) {
      for (std::uint64_t part = 0, bits = taken_[k]; bits != 0; ++part, bits >>= 8) {
        if ((bits & 0xff) == 0) continue;
        const auto voxel = static_cast<std::int64_t>(8 * k + part);
        const std::int64_t x = voxel / (size_[1] * size_[2]), y = voxel / size_[2] % size_[1], z = voxel % size_[2];
        visit(GridCell{first_[0] + x, first_[1] + y, first_[2] + z}, std::popcount(bits & 0xff));
      }
    }
  }

 private:
  static std::size_t word(std::int64_t number) { return static_cast<std::size_t>(number >> 6); }
  static std::uint64_t bit(std::int64_t number) { return std::uint64_t{1} << (number & 63); }

  GridCell first_, size_;
  std::vector<std::uint64_t> taken_;
};

SurfaceSamples sorted(const std::vector<std::pair<std::int64_t, Eigen::Vector3d>>& kept, const Octants& octants) {
  SurfaceSamples samples;
  const std::vector<std::uint32_t> before = octants.counts_before();
  samples.points_world_m.resize(3 * kept.size());
  for (const auto& [number, point] : kept) {
    Eigen::Map<Eigen::Vector3d>(samples.points_world_m.data() + 3 * octants.rank(number, before)) = point;
  }
  octants.visit_voxels([&](const GridCell& voxel, int count) {
    const auto index = static_cast<std::int64_t>(samples.voxels.size() / 3);
    samples.voxels.insert(samples.voxels.end(), voxel.begin(), voxel.end());
    samples.voxel_of_sample.insert(samples.voxel_of_sample.end(), static_cast<std::size_t>(count), index);
  });
  return samples;
}

}  // namespace

SurfaceSampler::SurfaceSampler(const World& world, double resolution_m, std::vector<Eigen::Vector2d> area_world_m,
                               const Eigen::AlignedBox3d& within_m)
    : world_(world), resolution_m_(resolution_m), area_world_m_(std::move(area_world_m)) {
  world_.water = {};
  Eigen::AlignedBox3d asked = within_m;
  Eigen::AlignedBox2d area;
  for (const Eigen::Vector2d& corner : area_world_m_) area.extend(corner);
  asked.min().head<2>() = asked.min().head<2>().cwiseMax(area.min());
  asked.max().head<2>() = asked.max().head<2>().cwiseMin(area.max());
  if (asked.isEmpty()) return;
  visit_triangles(asked, [&](const Corners& corners, bool) { box_m_.extend(box_around(corners)); });
  box_m_ = box_m_.intersection(asked);
  if (box_m_.isEmpty()) return;
  const double margin_m = kRounding * resolution_m;
  const Eigen::AlignedBox3d counted(box_m_.min().array() - margin_m, box_m_.max().array() + margin_m);
  double crossed_m2 = 0;
  visit_triangles(counted, [&](const Corners& corners, bool) {
    const Eigen::Vector3d doubled = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const bool inside = counted.contains(box_around(corners));
    const double share = inside ? 1 : area_within_m2(corners, counted) / std::max(doubled.norm() / 2, 1e-24);
    crossed_m2 += share * doubled.lpNorm<1>() / 2;
  });
  voxels_in_box_ = crossed_m2 / (resolution_m * resolution_m);
}

/// Calls visit(corners, is_solid) for each triangle whose bounds intersect the box: first those of the terrain, then
/// those of the solids.
template <typename Visit>
void SurfaceSampler::visit_triangles(const Eigen::AlignedBox3d& near_m, const Visit& visit) const {
  const auto visit_near = [&](const Corners& corners, bool is_solid) {
    if (near_m.intersects(box_around(corners))) visit(corners, is_solid);
  };
  if (const Heightfield* terrain = world_.terrain().get()) {
    const auto [first_column, end_column] = cells_near(*terrain, near_m, 0, terrain->nx() - 1);
    const auto [first_row, end_row] = cells_near(*terrain, near_m, 1, terrain->ny() - 1);
    for (std::size_t j = first_row; j < end_row; ++j) {
      for (std::size_t i = first_column; i < end_column; ++i) {
        for (std::size_t half = 0; half < 2; ++half) {
          const Triangle t = terrain->triangle(2 * (j * (terrain->nx() - 1) + i) + half);
          visit_near({terrain->vertex(t[0]), terrain->vertex(t[1]), terrain->vertex(t[2])}, false);
        }
      }
    }
  }
  for (const auto& solid : world_.solids()) {
    if (!near_m.intersects(Eigen::AlignedBox3d(solid->low_world_m, solid->high_world_m))) continue;
    const auto& vertices = solid->mesh_world.vertices_m;
    for (const Triangle& t : solid->mesh_world.triangles)
      visit_near({vertices[t[0]], vertices[t[1]], vertices[t[2]]}, true);
  }
}

/// Tests the point by the even-odd rule.
bool SurfaceSampler::is_inside_area(double x_m, double y_m) const {
  bool inside = false;
  for (std::size_t k = 0; k < area_world_m_.size(); ++k) {
    const Eigen::Vector2d &one = area_world_m_[k], &next = area_world_m_[(k + 1) % area_world_m_.size()];
    if ((one.y() > y_m) == (next.y() > y_m)) continue;
    if (x_m < one.x() + (y_m - one.y()) * ((next.x() - one.x()) / (next.y() - one.y()))) inside = !inside;
  }
  return inside;
}

SurfaceSamples SurfaceSampler::sample(const GridCell& first, const GridCell& end) const {
  if (box_m_.isEmpty()) return {};
  GridCell low = first, high = end;  // narrows the range to voxels that may contain surface
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto voxel = [&](double x) { return static_cast<std::int64_t>(std::floor(x / resolution_m_)); };
    low[axis] = std::max(first[axis], voxel(box_m_.min()[Eigen::Index(axis)]) - 1);
    high[axis] = std::min(end[axis], voxel(box_m_.max()[Eigen::Index(axis)]) + 2);
    if (low[axis] >= high[axis]) return {};
  }
  const auto corner_m = [&](const GridCell& cell, double margin) {
    return ((Eigen::Map<const Eigen::Matrix<std::int64_t, 3, 1>>(cell.data()).cast<double>().array() + margin) *
            resolution_m_)
        .matrix()
        .eval();
  };
  const Eigen::AlignedBox3d box_m(corner_m(low, -kRounding), corner_m(high, kRounding));
  Octants octants(low, high);
  std::vector<std::pair<std::int64_t, Eigen::Vector3d>> kept;
  visit_triangles(box_m, [&](const Corners& corners, bool is_solid) {
    SampledTriangle(corners, resolution_m_ / 2).visit_points(box_m, [&](const Eigen::Vector3d& point) {
      const std::int64_t octant = octants.number(point / (resolution_m_ / 2));
      if (octant < 0 || octants.is_taken(octant) || !is_inside_area(point.x(), point.y())) return;
      if (is_solid && world_.terrain() && world_.terrain()->height_at(point.x(), point.y()) > point.z()) return;
      octants.take(octant);
      kept.emplace_back(octant, point);
    });
  });
  return sorted(kept, octants);
}

}  // namespace uwsim
