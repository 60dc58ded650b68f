#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// A voxel of OctoMap's grid: floor(x / resolution) on each axis, +-2^20, packed as in
/// python/uwsim/mapping/voxel_keys.py.
using PackedKey = std::int64_t;

/// Determines the distances of voxels' centres from the true surface, and whether the surface passes through the
/// voxels. Distances are cached, so that a survey's map can be scored while it grows. Thread-safe.
class SurfaceVoxels {
 public:
  SurfaceVoxels(RayScene scene, double resolution_m);

  double resolution_m() const { return resolution_m_; }
  std::size_t known() const;

  /// Examines the voxels that contain points, given as rows of x, y, z; points beyond the grid are skipped.
  void look_at(std::span<const float> points_world_m);

  /// The distance from each voxel's centre to the surface, exact to double rounding. The result depends on neither
  /// earlier queries nor the number of threads.
  void distances(std::span<const PackedKey> voxels, std::span<double> distances_m, int threads);

  /// For each voxel, returns 1 if the surface passes through the voxel or within `kTouch_m` of it, else 0. The distance
  /// from the voxel's centre to the surface decides: 1 if the distance is at most half an edge, 0 if it exceeds half a
  /// diagonal. For distances in between, the voxel is split into eight cubes, at most `kHalvings` times, and these are
  /// tested in the same way.
  void hold_surface(std::span<const PackedKey> voxels, std::span<const double> distances_m,
                    std::span<std::uint8_t> hold, int threads) const;

  static constexpr double kTouch_m = 1e-3;  ///< allows for the rounding of points before they are mapped
  static constexpr int kHalvings = 5;

 private:
  struct Seen {
    PackedKey voxel = kFree;
    double distance_m = 0;
  };
  static constexpr PackedKey kFree = -1;

  std::size_t slot_of(PackedKey voxel) const;
  bool add(PackedKey voxel);
  void grow();
  void look_at(std::span<const PackedKey> fresh, int threads);
  Eigen::Vector3d centre_m(PackedKey voxel) const;
  bool holds_surface(const Eigen::Vector3d& centre_m, double half_m, double distance_m, int halvings) const;

  const RayScene scene_;
  const double resolution_m_;
  std::vector<Seen> table_;  ///< open addressing; a power of two long, at most half full
  std::size_t count_ = 0;
  mutable ForkSafeMutex<std::mutex> mutex_;
};

}  // namespace uwsim
