#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/pose.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sonar/multibeam_model.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// Destinations for the results of a ping, one value per beam. The rows of several pings may be contiguous.
struct PingRows {
  float* ranges_m;        ///< infinity without an echo
  float* points_sonar_m;  ///< beams x 3, row-major; NaN without an echo
  float* incidence_rad;   ///< between the beam and the surface's normal, 0..pi/2; NaN without an echo
  float* intensity_db;    ///< received level minus source level, plus the model's gain; -inf without an echo
  Label* labels;          ///< kNothing without an echo
  std::uint8_t* valid;    ///< 1 for an echo

  PingRows row(std::size_t ping, std::size_t beams) const;
};

/// One ping that owns its results; see PingRows.
struct MultibeamPing {
  std::vector<float> ranges_m, points_sonar_m, incidence_rad, intensity_db;
  std::vector<Label> labels;
  std::vector<std::uint8_t> valid;
};

/// A forward-looking multibeam in geometry mode (the paper's mode): one exact ray for each beam, along its axis.
///
/// Sound does not leave the water: surfaces above z = 0 return no echo, and a head above the water or below the terrain
/// receives no echoes. A head inside a solid receives echoes from the inside of its walls.
///
/// The echo's level follows the active sonar equation for a bottom that scatters by Lambert's law (Urick 1983,
/// "Principles of Underwater Sound", ch. 2 and 8): EL - SL = -40 log10 R - 2 alpha R + BS + 20 log10 cos(incidence),
/// with BS determined by the label of the surface hit, and Francois-Garrison absorption at the head. The insonified
/// area is omitted, so levels are comparable between beams of one ping, not between instruments.
class Multibeam {
 public:
  /// The bottom strength of rock (EM 2040 data sheet), for labels beyond those given.
  static constexpr double kRockStrength_db = -30;

  /// `strengths_db`: backscatter at normal incidence by label. `on`: if false, nothing is received. Throws InvalidValue
  /// naming the label.
  explicit Multibeam(const MultibeamModel& model, std::span<const double> strengths_db = {}, bool on = true);

  const MultibeamModel& model() const { return model_; }
  bool is_on() const { return on_; }
  std::size_t beams() const { return angles_rad_.size(); }
  /// The angles of the beams, see BeamAngles.
  const std::vector<float>& angles_rad() const { return angles_rad_; }

  /// The largest ping rate at which sound returns from `range_max_m` before the next ping, c / (2 R) with c at the
  /// head's depth, but at most the rate that the model's electronics allow.
  double ping_rate_max_hz(const Water& water, double head_z_m) const;

  MultibeamPing ping(const RayScene& scene, const Water& water, const Pose& world_from_sonar) const;
  void ping(const RayScene& scene, const Water& water, const Pose& world_from_sonar, const PingRows& rows) const;

 private:
  MultibeamModel model_;
  bool on_;
  std::vector<float> angles_rad_;
  std::vector<float> strengths_db_;      // including the gain, by label; the last one applies to all further labels
  std::vector<double> cosines_, sines_;  // of the beams' angles, padded to whole packets
};

}  // namespace uwsim
