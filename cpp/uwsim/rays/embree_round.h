#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/rays/tile_surfaces.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace uwsim {

/// The round shapes of one solid within a tile, by primitive, as Embree's callbacks know them. It must outlive the
/// tree.
struct RoundGeometry {
  std::uint32_t geometry;
  std::vector<RoundShape> shapes;
  Eigen::Vector3d middle_m;  ///< the tile's
  double box_margin_m;       ///< added to each shape's bounds
};

RoundGeometry round_geometry(const TileSurfaces& surfaces, std::uint32_t geometry);

/// Adds them to a tree. Rays meet these shapes in double, in callbacks, without facets.
void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round);

}  // namespace uwsim
