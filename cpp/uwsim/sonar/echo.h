#pragma once

#include <span>

#include "uwsim/world/world.h"

namespace uwsim {

/// The echo of one ray of a beam.
struct RayEcho {
  float range_m = 0;  ///< slant range: half of the two-way path
  float energy = 0;   ///< intensity at the receiver over the source's at 1 m, if it were all in one range cell
  float width_m = 0;  ///< extent in range, the range cell included
  float cosine = 0;   ///< of the incidence
  Label label = kNothing;
};

/// The echo of a beam: the sum of its rays' echoes over range, each spread over its width.
struct BeamEcho {
  float peak = 0;            ///< largest intensity over the source's; 0 without an echo
  float energy = 0;          ///< of the echo with the peak, in the unit of RayEcho::energy
  float centre_range_m = 0;  ///< centroid of that echo's energy
  float cosine = 0;          ///< of the incidence of its strongest ray
  Label label = kNothing;    ///< of its strongest ray

  /// Extent in range of a rectangular echo of the same peak and energy.
  float extent_m(float cell_m) const { return cell_m * energy / peak; }
};

inline constexpr int kRaysMax = 64;

/// The peak of the envelope and the echo around it: rays that follow each other in range within the sum of their half
/// widths. Separate surfaces, such as the bed behind a pipe's edge, form another echo and do not shift the centre.
/// Reorders `rays`. A ray's shape over range is (1 - u^2)^2 with u over 15/16 of its width: the same ratio of area to
/// height as a rectangle of that width.
BeamEcho beam_echo(std::span<RayEcho> rays, float cell_m);

}  // namespace uwsim
