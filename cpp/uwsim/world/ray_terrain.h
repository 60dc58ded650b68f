#pragma once

#include <cstdint>

#include "uwsim/world/ray_geometry.h"

namespace uwsim {

/// The terrain's cells in the ray tree: quads, which take half the nodes and memory of triangles. Embree cuts each from
/// its second corner to its fourth, as Heightfield does, so that a quad is a cell's two triangles. All corners are
/// raised, by more than float errs by: a ray from above that truly meets the terrain meets its raised twin before, and
/// because cells share their corners it cannot slip between two of them.
void attach_terrain(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::uint32_t geometry);

/// The surfaces' number of what Embree names in that tree, by where it is hit.
inline std::uint32_t member_number(std::uint32_t geometry, std::uint32_t primitive, float u, float v) {
  return geometry > kTerrain ? primitive : 2 * primitive + static_cast<std::uint32_t>(u + v > 1);
}

/// Calls `visit` with the surfaces' number of each of what Embree names.
template <typename Visit>
void for_each_member(std::uint32_t geometry, std::uint32_t primitive, const Visit& visit) {
  if (geometry > kTerrain) return visit(primitive);
  visit(2 * primitive);
  visit(2 * primitive + 1);
}

}  // namespace uwsim
