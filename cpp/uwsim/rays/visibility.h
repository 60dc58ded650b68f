#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// Points on surfaces in groups, such as the samples of a voxel: group g contains the points from `first[g]` up to, but
/// excluding, `first[g + 1]`.
struct PointGroups {
  std::span<const Eigen::Vector3d> points_world_m;
  std::span<const std::size_t> first;

  std::size_t count() const { return first.size() - 1; }
  std::span<const Eigen::Vector3d> points(std::size_t group) const {
    return points_world_m.subspan(first[group], first[group + 1] - first[group]);
  }
};

/// For each group, returns 1 if a viewpoint within `range_m` sees one of the group's points, else 0. A point is seen
/// unless a surface lies more than `tolerance_m` in front of it. The result does not depend on the number of threads.
///
/// Nearby viewpoints are tried first, since most groups are visible from one of them; then all others are tried. Points
/// inside round shapes, such as the bed inside a pipe, are skipped.
std::vector<std::uint8_t> seen_groups(const RayScene& scene, std::span<const Eigen::Vector3d> viewpoints_world_m,
                                      const PointGroups& groups, double range_m, double tolerance_m, int threads);

}  // namespace uwsim
