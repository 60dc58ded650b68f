#pragma once

#include <cstdint>

#include "uwsim/rays/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace uwsim {

/// Adds the terrain's cells to a tree, as quads, which need half the nodes and memory of triangles. Embree splits each
/// quad from its second to its fourth corner, as Heightfield does, so that a quad consists of a cell's two triangles.
/// All corners are raised (see raised_terrain.h). Open cells share their corners, so no ray can slip between two of
/// them.
void attach_terrain(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::uint32_t geometry);

/// Returns the surface number of the primitive that Embree reports. A quad consists of two triangles, so the number
/// depends on where the quad was hit.
inline std::uint32_t member_number(std::uint32_t geometry, std::uint32_t primitive, float u, float v) {
  return TileSurfaces::is_terrain(geometry) ? 2 * primitive + static_cast<std::uint32_t>(u + v > 1) : primitive;
}

/// Calls `visit` with the surface numbers of the primitive that Embree reports.
template <typename Visit>
void for_each_member(std::uint32_t geometry, std::uint32_t primitive, const Visit& visit) {
  if (!TileSurfaces::is_terrain(geometry)) return visit(primitive);
  visit(2 * primitive);
  visit(2 * primitive + 1);
}

}  // namespace uwsim
