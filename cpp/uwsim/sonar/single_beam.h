#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/imaging_acoustics.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// A profiling sonar: one pencil beam, round, that a motor steps about the head's z axis.
struct SingleBeamModel {
  ImagingAcoustics acoustics;
  double beam_width_rad = 0;  ///< between half-power points, two-way
  int rays_across = 0;        ///< of the square grid of rays over the beam
  double detection_db = 0;    ///< over the noise: an echo's peak below it is no echo

  void check() const;
};

struct SingleBeamProfiles {
  std::vector<float> level_db;  ///< [ping * bins + bin], dB re 1 uPa
  std::vector<float> ranges_m;  ///< infinity where there is no echo
};

/// One ping at each of the angles about the sonar frame's +z, from its x axis, positive to port. Ping k draws its
/// speckle as number `first_ping` + k.
///
/// The range is the centroid of the power about the echo's peak, out to where a running mean over five bins has fallen
/// to a tenth of it: near nadir that is the bottom straight below, oblique it is the beam's middle. 1 / R^2, Lambert's
/// law and absorption pull the centroid inwards, on a flat bottom under 45 degrees by less than a beam's width squared.
SingleBeamProfiles single_beam(const SingleBeamModel& model, const RayScene& scene, const Water& water,
                               const Pose& world_from_sonar, std::span<const double> angles_rad,
                               const RandomStream& random, std::uint64_t first_ping, int threads = 1);

}  // namespace uwsim
