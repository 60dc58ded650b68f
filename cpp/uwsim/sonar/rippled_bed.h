#pragma once

#include <Eigen/Core>
#include <array>

#include "uwsim/world/sand_ripples.h"

namespace uwsim {

/// Where a ray meets a bed, and how much of the bed it stands for.
struct BedPatch {
  Eigen::Vector3d point_world_m;
  Eigen::Vector3d normal_world;      ///< of any length
  Eigen::Vector3d direction_world;   ///< of the ray, unit
  double along_m = 0, across_m = 0;  ///< extents of the patch along the ray, on the bed, and across it
};

/// Ripples that a sonar meets on a bed, by the composite-roughness approximation (Jackson and Richardson 2007,
/// "High-Frequency Seafloor Acoustics", ch. 13; not checked): the backscatter of the bed's small roughness is averaged
/// over the slopes of its large one, per area of the mean bed. Ripples longer than a patch are followed: their slope
/// tilts it. The part that a patch averages, 1 - exp(-(k w)^2 / 12) of the mean square slope for a patch of width w
/// across the crests, spreads its slope to either side, so that the mean square slope is that of the ripples at any
/// distance. Valid where ripples are long and low compared with the wavelength's Rayleigh height, and shade little of
/// each other: facets that look away scatter nothing, but those behind a crest are not hidden. Ranges stay those of the
/// mean bed.
class RippledBed {
 public:
  explicit RippledBed(double across_rad) : ripples_(across_rad) {}

  /// The cosines of the incidence at two facets of a patch, equally large; 0 for one that looks away.
  std::array<double, 2> facets(const BedPatch& patch) const;

 private:
  SandRipples ripples_;
};

}  // namespace uwsim
