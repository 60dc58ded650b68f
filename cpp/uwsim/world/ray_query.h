#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/world/tile_surfaces.h"

struct RTCSceneTy;

namespace uwsim {

struct LabelledHit {
  TileHit hit;
  Label label;
};

/// Where a ray first meets anything of a tree within a sphere, between two distances; solved in double.
std::optional<LabelledHit> first_hit_around(RTCSceneTy* tree, const TileSurfaces& surfaces,
                                            const Eigen::Vector3d& point_world_m, double radius_m, const TileRay& ray,
                                            double from_m, double to_m);

/// Of each triangle of a solid's mesh: whether something but a neighbour comes near it, so that either may be hit
/// first; of each round shape: whether a mesh does.
std::vector<std::uint8_t> crowded_members(RTCSceneTy* tree, const TileSurfaces& surfaces, Label label);

/// The least of `nearest_m` and the distance to a triangle of the tree; of shapes it knows nothing. `meshes`: the tree
/// is of the meshes of what rays meet as shapes.
double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m);

}  // namespace uwsim
