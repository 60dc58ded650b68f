#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/mapping/occupancy_map.h"

namespace uwsim {

/// The Euclidean distance from each voxel of a box to the nearest occupied one, kept up to date as the map grows.
///
/// Computed by dynamicEDT3D, which ships with OctoMap (B. Lau, C. Sprunk, W. Burgard, "Efficient grid-based spatial
/// representations for robot navigation in dynamic environments", Robotics and Autonomous Systems 61(10), 2013): after
/// a change, only the voxels whose nearest obstacle may have changed are visited. Distances are between the centres of
/// voxels. They are truncated at a maximum distance. Shorter distances may be too long by a fraction of a voxel,
/// because each voxel chooses its nearest obstacle among those of its neighbours.
class DistanceField {
 public:
  struct Options {
    double max_distance_m = 5.0;       ///< at least a voxel, at most 1,000 voxels
    bool unknown_is_occupied = false;  ///< count unknown voxels as obstacles
  };

  /// Covers the voxels whose centres lie in a box. Throws InvalidValue for invalid options, and for a box with no
  /// voxels or with more than 32 million, which take a gigabyte.
  DistanceField(const OccupancyMap& map, const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                const Options& options);
  ~DistanceField();
  DistanceField(DistanceField&&) noexcept;

  /// Reads the map, which must be the one from which the field was made, and updates the distances. Returns the number
  /// of voxels in the box that became obstacles or are no longer obstacles.
  std::size_t update(const OccupancyMap& map);

  /// The distance at each point [m], interpolated trilinearly between the centres of voxels; NaN outside the box of
  /// centres. points_world_m: rows of x, y, z. Throws InvalidValue for points that are not finite.
  std::vector<float> distance_m(std::span<const double> points_world_m) const;
  /// The gradient of distance_m(), rows of x, y, z, without a unit; NaN outside.
  std::vector<double> gradient(std::span<const double> points_world_m) const;
  /// All distances [m], with z as the innermost index.
  std::vector<float> grid() const;

  const std::array<int, 3>& shape() const;
  /// The centre of the voxel with the lowest indices.
  const Eigen::Vector3d& low_centre_world_m() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
