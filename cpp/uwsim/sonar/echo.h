#pragma once

#include <span>

#include "uwsim/world/world.h"

namespace uwsim {

/// What one ray of a beam brings back.
struct RayEcho {
  float range_m = 0;  ///< slant range at which it shows: half the travel time's length of path
  float energy = 0;   ///< intensity at the receiver over that of the source at 1 m, were it all in one range cell
  float width_m = 0;  ///< length in range that it fills, the cell's own included
  float cosine = 0;   ///< of its incidence
  Label label = kNothing;
};

/// A beam's echo along range: the sum of what its rays bring back, each spread over its own width.
struct BeamEcho {
  float peak = 0;            ///< largest intensity over the source's; 0 where nothing came back
  float energy = 0;          ///< of the echo that has the peak, in the unit of RayEcho::energy
  float centre_range_m = 0;  ///< centre of that echo's energy
  float cosine = 0;          ///< of incidence, of its strongest ray
  Label label = kNothing;    ///< likewise

  /// Length in range of an even echo of the same peak and energy.
  float extent_m(float cell_m) const { return cell_m * energy / peak; }
};

inline constexpr int kRaysMax = 64;

/// The envelope where it is highest, and the echo about it: rays that follow each other in range within the sum of
/// their half widths. What lies apart, such as the bed behind a pipe's edge, is another echo and does not pull the
/// centre. Reorders `rays`. A ray's shape in range is (1 - u^2)^2, u over 15/16 of its width, as wide as an even one of
/// that width in the ratio of area to height.
BeamEcho beam_echo(std::span<RayEcho> rays, float cell_m);

}  // namespace uwsim
