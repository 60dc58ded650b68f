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
  bool false_detections = true;  ///< whether noise may be detected as a bottom
  bool range_noise = true;
  bool bending = false;  ///< whether rays follow the sound-speed profile
  double acidity_ph = 8;
  BottomMaterial bottom;                  ///< for labels beyond `materials`
  std::vector<BottomMaterial> materials;  ///< by label

  /// Throws InvalidValue that names the field.
  void check() const;
};

/// The head's motion during a ping, world frame.
struct HeadMotion {
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_world_rad_s = Eigen::Vector3d::Zero();
};

/// One ping in physics mode, one value for each beam; names shared with MultibeamPing have the same meaning. A beam
/// without a detection has infinity, NaN, -infinity or 0 in each array, as stated.
struct AcousticPing {
  std::vector<float> ranges_m;        ///< sound speed at the head x half the travel time; infinity
  std::vector<float> points_sonar_m;  ///< beams x 3: the range along the beam's axis at transmission; NaN
  std::vector<float> incidence_rad;   ///< true value at the strongest ray; NaN, also for false detections
  std::vector<float> intensity_db;    ///< received level less source level, plus gain, with speckle; -infinity
  std::vector<float> snr_db;          ///< at the detector, with noise; -infinity
  std::vector<float> travel_time_s;   ///< two-way; infinity
  /// The standard deviation of the echo's position, derived from the instrument's own parameters: that of its range,
  /// and that of its angle across the fan, which may lie anywhere in the beam's width: range x width / sqrt(12), the
  /// deviation of a uniform distribution (derived here; an error model of hydrography, such as Hare 1995's, has more
  /// terms). Infinity.
  std::vector<float> deviation_m;
  std::vector<Label> labels;             ///< true value; kNothing, also for false detections
  std::vector<std::uint8_t> valid;       ///< 1 for a detection, including false ones
  std::vector<std::uint8_t> detections;  ///< Detection

  /// A ping without any echo.
  static AcousticPing silent(std::size_t beams);
};

/// A multibeam in physics mode: its maximum range, range errors and gaps follow from its acoustic parameters.
///
/// Each beam is sampled by several rays (BeamFootprint). A ray returns the fraction Omega/n S cos(i) / R^2 10^(-2 alpha
/// R / 10) of the source's intensity: spherical spreading out and back (40 log R), the area of bottom that the ray's
/// share Omega/n of the beam covers (R^2 / cos i), Lambert's law S cos^2 i, and Francois-Garrison absorption, averaged
/// along the path. The rays' echoes are summed over range to an envelope (echo.h). Spreading then comes out as 20 log R
/// if one range cell contains the footprint, as 30 log R if slope or relief spreads the footprint over several cells,
/// and as 40 log R for a small target. Speckle comes from scatterers fixed in the world (SpeckleField): beams that
/// overlap, and pings from the same place, share it. The detector (BottomDetector) adds the receiver's noise, which
/// differs from ping to ping, and applies its threshold; it may also detect noise as an echo.
///
/// Motion: a ping is transmitted from one pose and received at another. The range is half of the path out and back to
/// the moved head. The fan rotates about its normal in between, so that a beam receives from the direction in which it
/// points at reception. Results are those of a raw instrument: motion is not corrected.
///
/// A head above the water or under the terrain detects nothing, not even noise.
///
/// Not modelled: side lobes, multipath, the surface's echo, Doppler, the near field (valid beyond the array's
/// length^2 / wavelength), focusing by refraction.
class AcousticMultibeam {
 public:
  /// Copies the parts of `water` that it needs. `bottom_m`: depth down to which absorption is tabulated. Throws
  /// InvalidValue.
  AcousticMultibeam(const MultibeamModel& fan, const AcousticSpec& spec, const Water& water, double bottom_m,
                    const RandomStream& stream);

  const MultibeamModel& fan() const { return fan_; }
  const AcousticSpec& spec() const { return spec_; }
  const SoundSpeedProfile& profile() const { return profile_; }

  /// Draws are keyed by tick and beam; the result does not depend on the number of threads.
  AcousticPing ping(const RayScene& scene, const Pose& world_from_sonar, const HeadMotion& motion, std::uint64_t tick,
                    int threads = 1) const;

 private:
  struct Transmission;  // common to all beams of a ping
  struct FanRays;       // the rays of some beams

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
  double figure_db_;  ///< signal-to-noise ratio of an echo without any loss, minus the model's gain
  BottomDetector detector_;
  SpeckleField speckle_;
  float share_sr_;   ///< solid angle of one ray of an unsteered beam
  float width_rad_;  ///< of an unsteered beam: the geometric mean of both widths
  /// by label, as ratios of intensity; the last one applies to all further labels
  std::vector<float> strengths_, reliefs_;
};

}  // namespace uwsim
