#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/imaging_acoustics.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// A side-scan sonar: to either side one beam, narrow along the track (the sonar frame's x axis) and wide across it.
struct SideScanModel {
  ImagingAcoustics acoustics;
  double along_width_rad = 0;     ///< along the track, between half-power points, two-way
  double vertical_width_rad = 0;  ///< across it, two-way
  double depression_rad = 0;      ///< of the beams' axes below the frame's level
  int planes = 0;                 ///< of rays across the track, spread over the beam's width along it
  double detection_db = 0;        ///< over the noise: where the first bottom return begins

  void check() const;
};

/// A ping each line. Levels in dB re 1 uPa by slant range: [ping * bins + bin].
struct SideScanLines {
  std::vector<float> port_db, starboard_db;
  std::vector<float> altitude_m;  ///< range of the first return, both sides together; infinity where there is none
};

/// One ping from each pose. Ping k draws its speckle as number `first_ping` + k, so pings may be asked for one by one.
///
/// Rays lie in planes across the track, from straight down to above the level: as dense as the bins are on a flat
/// bottom at the depth met straight below, and never sparser than a tenth of a degree. Port and starboard do not hear
/// each other.
SideScanLines side_scan(const SideScanModel& model, const RayScene& scene, const Water& water,
                        std::span<const Pose> world_from_sonar, const RandomStream& random, std::uint64_t first_ping,
                        int threads = 1);

}  // namespace uwsim
