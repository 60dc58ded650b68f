#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sonar/multibeam_model.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// One ping, a value a beam. Sound does not leave the water: what lies above z = 0 gives no echo, nor does a dry head.
/// Angles about the sonar frame's +z, positive to port, as in sensor_msgs/LaserScan.
struct MultibeamPing {
  std::vector<float> ranges_m;        ///< infinity where there is no echo
  std::vector<float> points_sonar_m;  ///< beams x 3, row-major; NaN where there is no echo
  std::vector<float> incidence_rad;   ///< between the beam and the surface's normal, 0..pi/2; NaN where no echo
  std::vector<float> intensity_db;    ///< received level less source level; -inf where there is no echo
  std::vector<Label> labels;
  std::vector<std::uint8_t> valid;  ///< 1 where there is an echo
};

/// A forward-looking multibeam in geometry mode (the paper's): one ray a beam along its axis.
///
/// The echo's level follows the active sonar equation for a bottom that scatters by Lambert's law (Urick 1983,
/// "Principles of Underwater Sound", ch. 2 and 8): EL - SL = -40 log10 R - 2 alpha R + BS + 20 log10 cos(incidence),
/// with BS = -30 dB (rock, EM 2040's data sheet) and Francois-Garrison absorption at the head. The insonified area is
/// left out, so it compares beams of one ping, not instruments.
class Multibeam {
 public:
  Multibeam(const MultibeamModel& model, const Pose& body_from_mount);

  const MultibeamModel& model() const { return model_; }
  /// Turns the head about its y axis: positive elevation points it up. Throws InvalidValue beyond +-pi/2.
  void aim(double elevation_rad);
  double elevation_rad() const { return elevation_rad_; }
  Pose body_from_sonar() const;
  /// Saves or restores where the head points. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

  MultibeamPing ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const;

 private:
  MultibeamModel model_;
  Pose body_from_mount_;
  double elevation_rad_ = 0;
  std::vector<Eigen::Vector3d> directions_sonar_;
};

}  // namespace uwsim
