#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

/// The echo of one ray of a beam.
struct RayEcho {
  float range_m = 0;  ///< slant range: half of the two-way path
  /// Ratio of the intensity at the receiver to the source's at 1 m, as if the whole echo fell into one range cell
  float energy = 0;
  float width_m = 0;  ///< extent in range, including the range cell
  float cosine = 0;   ///< cosine of the incidence
  Label label = kNothing;
  std::uint16_t ray = 0;  ///< its index within the beam
  float point_m2 = 0;     ///< part of width_m squared due to each point of the bottom: range cell and relief
};

/// The echo of a beam: the sum of its rays' echoes over range, each spread over its width.
struct BeamEcho {
  float peak = 0;                 ///< largest intensity, relative to the source's; 0 without an echo
  float energy = 0;               ///< of the echo that contains the peak, in the units of RayEcho::energy
  float centre_range_m = 0;       ///< centroid of that echo's energy
  float cosine = 0;               ///< cosine of the incidence of its strongest ray
  Label label = kNothing;         ///< label of its strongest ray
  std::span<const RayEcho> rays;  ///< rays of that echo, sorted by range
  bool of_surface = true;         ///< whether they sample one surface, so that the phase along the echo is a ramp

  /// Extent in range of a rectangular echo with the same peak and energy.
  float extent_m(float cell_m) const { return cell_m * energy / peak; }
};

inline constexpr int kRaysMax = 64;

/// Finds the peak of the envelope and the echo around it, which consists of rays that are separated in range by less
/// than the sum of their half widths. Separate surfaces, such as the bed behind a pipe's edge, form another echo and do
/// not shift the centre. Reorders `rays`. A ray's shape over range is (1 - u^2)^2 with u over 15/16 of its width, which
/// has the same ratio of area to height as a rectangle of that width.
BeamEcho beam_echo(std::span<RayEcho> rays, float cell_m);

/// The envelope of these rays at a range, in the units of BeamEcho::peak.
float envelope(std::span<const RayEcho> rays, float at_m, float cell_m);

/// The rays of a beam in the fan's frame.
struct BeamRays {
  const std::vector<Eigen::Vector2d>& offsets;  ///< from the axis, see BeamFootprint::offsets
  Eigen::Ref<const Eigen::Matrix3Xf> directions;
  Eigen::Vector3f axis;
};

/// The range at which the beam's axis hits the echo's surface, where the phase difference between the two halves of the
/// array is zero; NaN if the axis is not among the rays.
///
/// Over a plane, the inverse of the range projected on the axis is linear in the rays' offsets, so fitting a line to it
/// yields the exact range on the axis at any incidence. A mean of the rays' ranges would not be exact, since the far
/// side of a footprint is longer and its echo weaker.
double axis_range_m(std::span<const RayEcho> echo, const BeamRays& beam);

/// The echo as received along the beam's axis.
struct AxisEcho {
  double level;     ///< in the units of BeamEcho::peak
  double extent_m;  ///< extent of a rectangle with that level and the echo's energy
};

/// The echo at the range `axis_m` of the axis.
///
/// If all rays are in the echo, level = energy x exp(-d^2 / (2 var r)) x cell / extent, where the extent is that of a
/// rectangle as high as the Gaussian echo, sqrt(2 pi var r + point_m2). This uses only the rays' first and second
/// moments, which equal those of the pattern for any number of rays; the density of rays near the axis does not (with 8
/// rays, it is 1 to 2 dB too low). d is the distance from the rays' mean range to the centroid of their energy, which
/// is shifted towards the stronger, near side; the factor is exact if energy falls exponentially over a Gaussian
/// footprint. If rays are missing, the level is the sum of the rays' shapes.
AxisEcho axis_echo(const BeamEcho& echo, const BeamRays& beam, double axis_m, float cell_m);

}  // namespace uwsim
