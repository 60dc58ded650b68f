#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/core/random.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/sonar/beam_footprint.h"
#include "uwsim/sonar/bottom_detector.h"
#include "uwsim/sonar/echo.h"
#include "uwsim/sonar/multibeam_model.h"
#include "uwsim/sonar/speckle_field.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The acoustic parameters of a multibeam in physics mode.
struct AcousticSpec {
  SonarFigures figures;
  int rays_per_beam = 8;
  bool false_detections = true;  ///< whether noise may be detected as a bottom echo
  bool range_noise = true;
  bool bending = false;  ///< whether rays follow the sound-speed profile
  double acidity_ph = 8;
  BottomMaterial bottom;                  ///< for labels that `materials` does not cover
  std::vector<BottomMaterial> materials;  ///< by label

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// The motion of the head during a ping, world frame.
struct HeadMotion {
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_world_rad_s = Eigen::Vector3d::Zero();
};

/// One ping in physics mode, with one value per beam. Fields that also exist in MultibeamPing have the same meaning.
/// For a beam without a detection, each array contains the value stated at the end of its comment: infinity, NaN,
/// -infinity or 0.
struct AcousticPing {
  std::vector<float> ranges_m;        ///< sound speed at the head x half the travel time; infinity
  std::vector<float> points_sonar_m;  ///< beams x 3: the range along the beam's axis at transmission; NaN
  std::vector<float> incidence_rad;   ///< true value for the strongest ray; NaN, also for false detections
  std::vector<float> intensity_db;    ///< received level minus source level, plus gain, with speckle; -infinity
  std::vector<float> snr_db;          ///< at the detector, with noise; -infinity
  std::vector<float> travel_time_s;   ///< two-way; infinity
  std::vector<float> deviation_m;     ///< standard deviation of the range, by the detector's own estimate; infinity
  /// The standard deviation of the echo's place, vertical and horizontal, from that of its range and that of its angle
  /// across the fan, which may lie anywhere in the transmitter's width: range x width / sqrt(12), the deviation of a
  /// uniform distribution. The sonar's share of the total vertical and horizontal uncertainty (TVU, THU) of IHO S-44,
  /// at one standard deviation; Hare 1995's error model also has those of position, attitude and sound speed. Infinity.
  std::vector<float> vertical_deviation_m, horizontal_deviation_m;
  std::vector<Label> labels;             ///< true value; kNothing, also for false detections
  std::vector<std::uint8_t> valid;       ///< 1 for a detection, including false ones
  std::vector<std::uint8_t> detections;  ///< Detection

  /// A ping without echoes.
  static AcousticPing silent(std::size_t beams);
};

/// A multibeam in physics mode: its maximum range, range errors and gaps result from its acoustic parameters.
///
/// Each beam is sampled by several rays (BeamFootprint). Each of a beam's n rays returns the fraction Omega/n S cos(i)
/// / R^2 10^(-2 alpha R / 10) of the source's intensity. The factors are spherical spreading out and back (40 log R),
/// the area of bottom covered by the ray's share Omega/n of the beam (R^2 / cos i), Lambert's law S cos^2 i, and
/// Francois-Garrison absorption averaged along the path. The rays' echoes are summed over range to an envelope
/// (echo.h). The resulting spreading is 20 log R if one range cell contains the footprint, 30 log R if slope or relief
/// spreads the footprint over several cells, and 40 log R for a small target. Speckle comes from scatterers that are
/// fixed in the world (SpeckleField), so overlapping beams and pings from the same place share it. The detector
/// (BottomDetector) adds the receiver's noise, which differs from ping to ping, and applies its threshold; it may also
/// detect noise as an echo.
///
/// Motion: a ping is transmitted from one pose and received at another. The range is half of the path from the head to
/// the bottom and back to the head's new position. The fan rotates about its normal in between, so a beam receives from
/// the direction in which it points at reception. Results are those of a raw instrument, without motion correction.
///
/// A head above the water or below the terrain detects nothing, not even noise.
///
/// Not modelled: side lobes, multipath, the surface's echo, Doppler, the near field (valid beyond the array's length^2
/// / wavelength), focusing by refraction.
class AcousticMultibeam {
 public:
  /// Copies the required parts of `water`. `bottom_m`: depth down to which absorption is tabulated. Throws
  /// InvalidValue.
  AcousticMultibeam(const MultibeamModel& fan, const AcousticSpec& spec, const Water& water, double bottom_m,
                    const RandomStream& stream);

  const MultibeamModel& fan() const { return fan_; }
  const AcousticSpec& spec() const { return spec_; }
  const SoundSpeedProfile& profile() const { return profile_; }

  /// Random draws are keyed by tick and beam; the result does not depend on the number of threads.
  AcousticPing ping(const RayScene& scene, const Pose& world_from_sonar, const HeadMotion& motion, std::uint64_t tick,
                    int threads = 1) const;

 private:
  struct Transmission;  // common to all beams of a ping
  struct FanRays;       // the rays of a subset of beams

  void ping_beams(const Transmission& sent, std::size_t first, std::size_t last, AcousticPing& ping) const;
  Eigen::Matrix3Xf ray_directions_world(const Transmission& sent, std::size_t first, std::size_t last) const;
  void cast_straight(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const;
  void cast_bent_rays(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const;
  RayEcho ray_echo(const Transmission& sent, std::size_t beam, float length_m, float range_m, float cosine,
                   double depth_m, Label label) const;
  BottomDetection detect(const Transmission& sent, std::size_t beam, const BeamEcho& echo) const;
  void record(const Transmission& sent, std::size_t beam, const BeamEcho& echo, const BottomDetection& found,
              AcousticPing& ping) const;

  MultibeamModel fan_;
  AcousticSpec spec_;
  RandomStream stream_;
  BeamFootprint footprint_;
  SoundSpeedProfile profile_;
  AbsorptionColumn absorption_;
  double figure_db_;  ///< signal-to-noise ratio of a lossless echo, minus the model's gain
  BottomDetector detector_;
  SpeckleField speckle_;
  float share_sr_;   ///< solid angle of one ray of an unsteered beam
  float width_rad_;  ///< of an unsteered beam: the geometric mean of both widths
  /// By label, as ratios of intensity; the last entry applies to all further labels
  std::vector<float> strengths_, reliefs_;
};

}  // namespace uwsim
