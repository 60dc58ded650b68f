#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/imaging_acoustics.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// A forward-looking imaging sonar: one broad transmission, many narrow receiving beams side by side.
struct ForwardLookingModel {
  ImagingAcoustics acoustics;
  int beams = 0;
  double field_of_view_rad = 0;   ///< between the outermost beams' axes
  double beam_width_rad = 0;      ///< of a beam across, between half-power points
  double vertical_width_rad = 0;  ///< of transmitter and receiver together, two-way
  double taper = 0;               ///< the receiving array's shading, see BeamPattern
  int columns_per_beam = 0;       ///< upright planes of rays between two beams' axes
  int rays_per_column = 0;

  void check() const;
  double bearing_rad(int beam) const { return -field_of_view_rad / 2 + beam * spacing_rad(); }
  double spacing_rad() const { return beams > 1 ? field_of_view_rad / (beams - 1) : beam_width_rad; }
};

/// One look: level_db[bin * beams + beam], dB re 1 uPa with the time-varied gain where that is on. Bearings about the
/// sonar frame's +z, positive to port; its x axis is the picture's middle.
///
/// Columns of rays sample the scene over the vertical aperture; each beam is the sum of the columns' echoes weighted by
/// the receiving array's pattern. Left out: echoes of the surface and by several bounces, motion within a look, and the
/// curvature of a line array's beams away from the level plane.
std::vector<float> forward_look(const ForwardLookingModel& model, const RayScene& scene, const Water& water,
                                const Pose& world_from_sonar, const RandomStream& random, std::uint64_t tick,
                                int threads = 1);

}  // namespace uwsim
