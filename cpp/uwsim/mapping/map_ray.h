#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "uwsim/mapping/map_engine.h"

namespace uwsim {

enum class MapRayEnd : std::int8_t {
  unknown = -1,  ///< in an unknown voxel that the ray was not allowed to enter
  free = 0,      ///< at the ray's maximum range or at the cube's edge
  hit = 1,       ///< in an occupied voxel
};

struct MapRayHit {
  MapRayEnd end;
  VoxelKey voxel;  ///< the last voxel that the ray reached
};

/// Follows a ray to the first occupied voxel, with the steps of octomap::OcTree::castRay, in float32. max_range_m:
/// measured to a voxel's centre; 0 for no limit. The origin must lie in the cube, and the direction must not be zero.
MapRayHit cast_map_ray(const MapEngine& engine, double resolution_m, const Eigen::Vector3f& origin_m,
                       const Eigen::Vector3f& direction, bool ignore_unknown, double max_range_m);

/// Calls visit(voxel) for each voxel along such a ray, until it returns false.
void follow_map_ray(double resolution_m, const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction,
                    double max_range_m, const std::function<bool(const VoxelKey&)>& visit);

}  // namespace uwsim
