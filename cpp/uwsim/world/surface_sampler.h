#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

/// A voxel of OctoMap's grid: floor(x / resolution) on each axis.
using GridCell = std::array<std::int64_t, 3>;

/// Points on the true surface, sorted by voxel, and the voxels that contain them, sorted.
struct SurfaceSamples {
  std::vector<double> points_world_m;         ///< rows of x, y, z
  std::vector<std::int64_t> voxel_of_sample;  ///< index into the voxels
  std::vector<std::int64_t> voxels;           ///< rows of x, y, z
};

/// Samples the triangles of a world's terrain and solids inside a polygon and a box, at a spacing of at most half a
/// voxel. At most one point is kept per octant of a voxel. Parts of solids below the terrain, such as the lower half of
/// a buried pipe, do not count as surface. Thread-safe.
class SurfaceSampler {
 public:
  /// area_world_m: corners of a simple polygon. within_m: may be infinite.
  SurfaceSampler(const World& world, double resolution_m, std::vector<Eigen::Vector2d> area_world_m,
                 const Eigen::AlignedBox3d& within_m);

  /// A box that encloses all the surface to be sampled, inside the polygon's bounds; empty if there is none.
  const Eigen::AlignedBox3d& box_m() const { return box_m_; }
  /// Approximate number of voxels in that box that the triangles pass through: a plane of area A and unit normal n
  /// crosses A |n|_1 / resolution^2 voxels.
  double voxels_in_box() const { return voxels_in_box_; }

  /// The samples in the voxels from `first` up to, but excluding, `end` on each axis. The result for a voxel does not
  /// depend on how the grid is divided.
  SurfaceSamples sample(const GridCell& first, const GridCell& end) const;

 private:
  template <typename Visit>
  void visit_triangles(const Eigen::AlignedBox3d& near_m, const Visit& visit) const;
  bool is_inside_area(double x_m, double y_m) const;

  World world_;
  double resolution_m_;
  std::vector<Eigen::Vector2d> area_world_m_;
  Eigen::AlignedBox3d box_m_;
  double voxels_in_box_ = 0;
};

}  // namespace uwsim
