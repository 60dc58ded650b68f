#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/rays/tile_surfaces.h"

struct RTCSceneTy;

namespace uwsim {

// Embree's tree as an index of the surfaces near a point; all results are computed in double.

struct LabelledHit {
  TileHit hit;
  Label label;
};

/// The first hit of a ray, between two distances, on any surface within a sphere.
std::optional<LabelledHit> first_hit_around(RTCSceneTy* tree, const TileSurfaces& surfaces,
                                            const Eigen::Vector3d& point_world_m, double radius_m, const TileRay& ray,
                                            double from_m, double to_m);

/// Determines, for each triangle of a solid's mesh, whether a surface other than its neighbours is so close that a cast
/// in float cannot tell which of the two is hit first; and, for each round shape, whether a mesh is that close.
std::vector<std::uint8_t> crowded_members(RTCSceneTy* tree, const TileSurfaces& surfaces, Label label);

/// The smaller of `nearest_m` and the distance to the tree's nearest triangle, ignoring round shapes. `meshes`: whether
/// the tree contains the meshes of solids whose shapes rays hit.
double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m);

}  // namespace uwsim
