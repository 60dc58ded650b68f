#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/core/random.h"
#include "uwsim/sonar/beam_footprint.h"
#include "uwsim/sonar/echo.h"
#include "uwsim/sonar/multibeam_model.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// How a beam's range was found.
enum class Detection : std::uint8_t { kNone = 0, kAmplitude = 1, kPhase = 2, kFalse = 3 };

/// What makes a multibeam an acoustic instrument.
struct AcousticSpec {
  SonarFigures figures;
  int rays_per_beam = 8;
  bool false_detections = true;  ///< whether noise may be taken for a bottom
  bool range_noise = true;
  bool bending = false;  ///< whether the sound speed's profile bends the beams
  double acidity_ph = 8;
  BottomMaterial bottom;                  ///< of what has no line in `materials`
  std::vector<BottomMaterial> materials;  ///< by label

  /// Throws InvalidValue that names the field.
  void check() const;
};

/// The head's motion while a ping is under way, in the world.
struct HeadMotion {
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_world_rad_s = Eigen::Vector3d::Zero();
};

/// One ping, a value a beam; as MultibeamPing where names agree.
struct AcousticPing {
  std::vector<float> ranges_m;           ///< sound speed at the head x half the travel time; infinity without detection
  std::vector<float> points_sonar_m;     ///< beams x 3: range along the beam's axis at transmission; NaN without
  std::vector<float> incidence_rad;      ///< true, of the strongest ray; NaN without and where false
  std::vector<float> intensity_db;       ///< received level less source level, speckle included; -inf without
  std::vector<float> snr_db;             ///< at the detector, noise included; -inf without
  std::vector<float> travel_time_s;      ///< two-way; infinity without
  std::vector<Label> labels;             ///< true; kNothing without and where false
  std::vector<std::uint8_t> valid;       ///< 1 where something was detected, be it false
  std::vector<std::uint8_t> detections;  ///< Detection
};

/// A multibeam in physics mode: what its range, its errors and its gaps come from.
///
/// Several rays a beam (BeamFootprint). Each brings back, of the source's intensity, Omega/n S cos(i) / R^2
/// 10^(-2 alpha R / 10): spherical spreading out and back (40 log R), the bottom that the ray's share Omega/n of the
/// beam covers (R^2 / cos i), Lambert's law S cos^2 i, Francois-Garrison absorption, its mean along the path. Rays add
/// up along range (echo.h) to an envelope, so that spreading comes out as 20 log R where one range cell holds the
/// footprint, 30 log R where slope or relief draws it out, 40 log R of a small target. The detector (sonar_equation.h)
/// compares the faded echo with its threshold and takes its range by phase where it holds at least four looks (assumed:
/// a phase ramp needs several) and phase errs less, else by amplitude; or takes noise for an echo.
///
/// Motion: a ping is sent from one pose and heard from another. The range is half of the way out and back to where the
/// head has moved; the fan turns about its normal between, so that a beam hears where it points at reception. Soundings
/// are as a raw instrument gives them: motion is not corrected.
///
/// A head above the water or under the terrain hears nothing, not even noise.
///
/// Left out: side lobes, multiple paths, the surface's echo, Doppler, near field (valid beyond the array's length^2 /
/// wavelength), refraction's focusing.
class AcousticMultibeam {
 public:
  /// Copies what it needs. `bottom_m`: depth down to which absorption is tabulated. Throws InvalidValue.
  AcousticMultibeam(const MultibeamModel& fan, const AcousticSpec& spec, const Water& water, double bottom_m,
                    const RandomStream& stream);

  const MultibeamModel& fan() const { return fan_; }
  const AcousticSpec& spec() const { return spec_; }
  const SoundSpeedProfile& profile() const { return profile_; }

  /// Draws are keyed by tick and beam; the same ping whatever the number of threads.
  AcousticPing ping(const RayScene& scene, const Pose& world_from_sonar, const HeadMotion& motion, std::uint64_t tick,
                    int threads = 1) const;

 private:
  struct Moment;  // what all beams of a ping share

  void ping_beams(const Moment& now, std::size_t first, std::size_t last, AcousticPing& ping) const;
  void cast_straight(const Moment& now, const Eigen::Matrix3Xf& directions_world, std::span<RayEcho> echoes) const;
  void cast_along_arcs(const Moment& now, const Eigen::Matrix3Xf& directions_world, std::span<RayEcho> echoes) const;
  RayEcho echo_of(const Moment& now, float length_m, float range_m, float cosine, double depth_m, Label label) const;
  void detect(const Moment& now, std::size_t beam, const BeamEcho& echo, AcousticPing& ping) const;

  MultibeamModel fan_;
  AcousticSpec spec_;
  RandomStream stream_;
  BeamFootprint footprint_;
  SoundSpeedProfile profile_;
  AbsorptionColumn absorption_;
  double figure_db_;
  double system_ratio_;                     ///< signal over noise of an echo that lost nothing
  double threshold_ratio_;                  ///< DT likewise
  float share_sr_;                          ///< of the beam's solid angle, a ray's
  float width_rad_;                         ///< of the beam, the root of both widths' product
  std::vector<float> strengths_, reliefs_;  ///< by label, as ratios of intensity; the last is everything else's
};

}  // namespace uwsim
