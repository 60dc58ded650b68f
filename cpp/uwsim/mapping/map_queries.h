#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "uwsim/mapping/map_engine.h"

/// Questions to a map that both engines answer alike: in keys, from the corner of the cube, and in the tree's metres.
namespace uwsim {

inline constexpr int kHalfExtent = 1 << (kTreeDepth - 1);

/// A cube of 2^levels voxels.
struct MapCube {
  VoxelKey corner;
  int levels;
  float log_odds;
};

using CubeVisitor = std::function<void(const MapCube&)>;

/// The leaves of OctoMap's pruned tree, in Morton order: eight equal ones are one, up to an eighth of the cube.
void for_each_pruned_leaf(const MapEngine& engine, const CubeVisitor& visit);

/// Cubes of 2^levels voxels in Morton order, of which something is known: the greatest of their log-odds, as OctoMap's
/// inner nodes have it.
void for_each_cell(const MapEngine& engine, int levels, const CubeVisitor& visit);

/// Voxels of a box that are known, in Morton order.
void for_each_voxel_in(const MapEngine& engine, const KeyBox& box, const CubeVisitor& visit);

enum class RayEnd : std::int8_t {
  unknown = -1,  ///< came to an unknown voxel, and was not to go on
  free = 0,      ///< came to its greatest range, or the cube's edge
  hit = 1,       ///< came to an occupied voxel
};

struct RayCast {
  RayEnd end;
  VoxelKey voxel;  ///< the last that it came to
};

/// The first occupied voxel along a ray, as octomap::OcTree::castRay finds it: in float32, the same steps. max_range_m:
/// to a voxel's centre; 0 for no limit. The origin must lie in the cube, the direction must not be zero.
RayCast cast_ray(const MapEngine& engine, double resolution_m, const Eigen::Vector3f& origin_m,
                 const Eigen::Vector3f& direction, bool ignore_unknown, double max_range_m);

}  // namespace uwsim
