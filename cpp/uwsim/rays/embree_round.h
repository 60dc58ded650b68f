#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/rays/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace uwsim {

/// The round shapes of one solid within a tile, by primitive, for Embree's callbacks. It must outlive the tree.
struct RoundGeometry {
  std::uint32_t geometry;
  std::vector<RoundShape> shapes;
  Eigen::Vector3d middle_m;  ///< middle of the tile
  double box_margin_m;       ///< added to each shape's bounds
};

RoundGeometry round_geometry(const TileSurfaces& surfaces, std::uint32_t geometry);

/// Adds the shapes to a tree. Callbacks intersect rays with them in double, without facets.
void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round);

}  // namespace uwsim
