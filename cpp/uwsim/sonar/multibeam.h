#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sonar/multibeam_model.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// Where a ping's results go, a value a beam; the rows of several pings may follow each other.
struct PingRows {
  float* ranges_m;        ///< infinity where there is no echo
  float* points_sonar_m;  ///< beams x 3, row-major; NaN where there is no echo
  float* incidence_rad;   ///< between the beam and the surface's normal, 0..pi/2; NaN where there is no echo
  float* intensity_db;    ///< received level less source level; -inf where there is no echo
  Label* labels;
  std::uint8_t* valid;  ///< 1 where there is an echo

  PingRows row(std::size_t ping, std::size_t beams) const;
};

/// One ping that owns its results; see PingRows.
struct MultibeamPing {
  std::vector<float> ranges_m, points_sonar_m, incidence_rad, intensity_db;
  std::vector<Label> labels;
  std::vector<std::uint8_t> valid;
};

/// A forward-looking multibeam in geometry mode (the paper's): one ray a beam along its axis. Angles are about the
/// sonar frame's +z, positive to port, as in sensor_msgs/LaserScan.
///
/// Sound does not leave the water: what lies above z = 0 gives no echo, and a head above the water or under the terrain
/// hears nothing. A head inside a solid hears its walls from within.
///
/// The echo's level follows the active sonar equation for a bottom that scatters by Lambert's law (Urick 1983,
/// "Principles of Underwater Sound", ch. 2 and 8): EL - SL = -40 log10 R - 2 alpha R + BS + 20 log10 cos(incidence),
/// with BS = -30 dB (rock, EM 2040's data sheet) and Francois-Garrison absorption at the head. The insonified area is
/// left out, so it compares beams of one ping, not instruments.
class Multibeam {
 public:
  Multibeam(const MultibeamModel& model, const Pose& body_from_mount);

  const MultibeamModel& model() const { return model_; }
  std::size_t beams() const { return angles_rad_.size(); }
  /// Of the beams about +z.
  const std::vector<float>& angles_rad() const { return angles_rad_; }

  /// Where the head is to point: it turns about its y axis as time passes, at the model's tilt rate; positive elevation
  /// points it up. Throws InvalidValue beyond +-pi/2.
  void aim(double elevation_rad);
  /// As aim, but it points there at once.
  void point(double elevation_rad);
  /// Lets time pass; the head turns towards where it was aimed.
  void advance(double duration_s);
  /// Where it points now, and where it was aimed.
  double elevation_rad() const { return elevation_rad_; }
  double aimed_rad() const { return aimed_rad_; }
  Pose body_from_sonar() const;
  /// Saves or restores where the head points. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

  /// At most so many pings a second reach `range_max_m` and back before the next leaves: c / (2 R), c at the head's
  /// depth; nor more than the model's electronics allow.
  double ping_rate_max_hz(const Water& water, double head_z_m) const;

  MultibeamPing ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const;
  void ping(const RayScene& scene, const Water& water, const Pose& world_from_body, const PingRows& rows) const;

 private:
  MultibeamModel model_;
  Pose body_from_mount_;
  double elevation_rad_ = 0, aimed_rad_ = 0;
  std::vector<float> angles_rad_;
  std::vector<double> ahead_, aside_;  // of each beam's unit vector, filled up to whole packets
};

}  // namespace uwsim
