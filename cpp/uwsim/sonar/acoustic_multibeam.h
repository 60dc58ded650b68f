#pragma once

#include <cstdint>
#include <optional>
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
#include "uwsim/sonar/rippled_bed.h"
#include "uwsim/sonar/scatter_curve.h"
#include "uwsim/sonar/speckle_field.h"
#include "uwsim/sonar/water_targets.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The acoustic parameters of a multibeam in physics mode.
struct AcousticSpec {
  SonarParameters parameters;
  int rays_per_beam = 8;
  bool false_detections = true;  ///< whether noise may be detected as a bottom echo
  bool range_noise = true;
  bool bending = false;                      ///< whether rays follow the sound-speed profile
  bool multipath = false;                    ///< whether echoes with several bounces are received, see ghosts.cpp
  std::optional<double> volume_strength_db;  ///< backscatter per cubic metre of water, re 1/m
  double acidity_ph = 8;
  BottomMaterial bottom;                  ///< for labels that `materials` does not cover
  std::vector<BottomMaterial> materials;  ///< by label
  std::vector<WaterTargets> targets;      ///< fish and bubbles in the water

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// The motion of the head during a ping, world frame.
struct HeadMotion {
  Eigen::Vector3d velocity_world_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_world_rad_s = Eigen::Vector3d::Zero();
};

/// Options of a ping: the results to compute besides its detections.
struct PingRequest {
  double time_s = 0;          ///< moves the bubbles of a seep
  bool water_column = false;  ///< whether to compute AcousticPing::water_column_db
};

/// One ping in physics mode, with one value per beam. Fields that also exist in MultibeamPing have the same meaning.
/// For a beam without a detection, each array contains the value stated at the end of its comment: infinity, NaN,
/// -infinity or 0.
struct AcousticPing {
  std::vector<float> ranges_m;        ///< sound speed at the head x half the travel time; infinity
  std::vector<float> points_sonar_m;  ///< beams x 3: the range along the beam's axis at transmission; NaN
  /// True value for the strongest ray; NaN, including for false detections, ghosts, and targets in the water
  std::vector<float> incidence_rad;
  std::vector<float> intensity_db;   ///< received level minus source level, plus gain, with speckle; -infinity
  std::vector<float> snr_db;         ///< at the detector, with noise; -infinity
  std::vector<float> travel_time_s;  ///< two-way; infinity
  std::vector<float> deviation_m;    ///< standard deviation of the range, by the detector's own estimate; infinity
  /// The vertical and horizontal standard deviations of the echo's position, due to the deviations of its range and of
  /// its angle across the fan. The angle may lie anywhere within the transmitter's width, so its contribution is range
  /// x width / sqrt(12), as for a uniform distribution. This is the sonar's share of the total vertical and horizontal
  /// uncertainty (TVU, THU) of IHO S-44, at one standard deviation; the error model of Hare 1995 also includes errors
  /// of position, attitude and sound speed. Infinity.
  std::vector<float> vertical_deviation_m, horizontal_deviation_m;
  /// True value; kNothing, including for false detections, ghosts, and targets in the water
  std::vector<Label> labels;
  std::vector<std::uint8_t> valid;       ///< 1 for a detection, including false ones
  std::vector<std::uint8_t> detections;  ///< Detection
  /// The water column, beams x samples: the level of each sample in the units of intensity_db, with speckle and noise.
  /// Empty unless requested. Sample k is the mean power over ranges [k, k + 1] x water_column_sample_m.
  std::vector<float> water_column_db;
  double water_column_sample_m = 0;

  /// A ping without echoes.
  static AcousticPing silent(std::size_t beams);
};

/// A multibeam in physics mode: its maximum range, range errors and gaps result from its acoustic parameters.
///
/// Each beam is sampled by several rays (BeamFootprint). Each of the n rays of a beam returns the fraction Omega/n S
/// cos(i) / R^2 10^(-2 alpha R / 10) of the source's intensity. The factors are spherical spreading out and back (40
/// log R), the area of bottom covered by the ray's share Omega/n of the beam (R^2 / cos i), Lambert's law S cos^2 i,
/// and Francois-Garrison absorption averaged along the path. Over ripples of sand, S cos^2 i is the mean of those at
/// the facets of the ray's share (RippledBed). The rays' echoes are summed over range to an envelope (echo.h). The
/// resulting spreading is 20 log R if one range cell contains the footprint, 30 log R if slope or relief spreads the
/// footprint over several cells, and 40 log R for a small target. Speckle comes from scatterers that are fixed in the
/// world (SpeckleField), so overlapping beams and pings from the same place share it. The detector (BottomDetector)
/// adds the receiver's noise, which differs from ping to ping, and applies its threshold; it may also detect noise as
/// an echo.
///
/// Motion: a ping is transmitted from one pose and received at another. The range is half of the path from the head to
/// the bottom and back to the head's new position. The fan rotates about its normal in between, so a beam receives from
/// the direction in which it points at reception. Results are those of a raw instrument, without motion correction.
///
/// A head above the water or below the terrain detects nothing, not even noise.
///
/// Optional: backscatter by angle (Seabed); ghosts (ghosts.cpp); targets in the water (WaterTargets). A beam has one
/// detection: the strongest of the bottom's echo, ghosts and targets. Volume reverberation, sv Omega cell / R^2 10^(-2
/// alpha R / 10) of the source's intensity (Urick 1983, ch. 8), adds to the noise in which echoes are detected.
///
/// Not modelled: side lobes, the surface's own backscatter, Doppler, the near field (valid beyond the array's length^2
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

  /// The largest number of samples of a beam's water column. A sample is one range cell, or as many whole cells as this
  /// bound requires.
  static constexpr std::size_t kSamplesMax = 4096;

  /// Random draws are keyed by tick and beam; the result does not depend on the number of threads.
  AcousticPing ping(const RayScene& scene, const Pose& world_from_sonar, const HeadMotion& motion, std::uint64_t tick,
                    int threads = 1, const PingRequest& request = {}) const;

 private:
  struct Transmission;                                    // common to all beams of a ping
  struct FanRays;                                         // the rays of a subset of beams
  struct HitLanes;                                        // where sixteen rays meet surfaces
  using OtherEchoes = std::vector<std::vector<RayEcho>>;  // of ghosts and targets, by beam

  void ping_beams(const Transmission& sent, std::size_t first, std::size_t last, OtherEchoes& others,
                  AcousticPing& ping) const;
  Eigen::Matrix3Xf ray_directions_world(const Transmission& sent, std::size_t first, std::size_t last) const;
  void cast_straight(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const;
  void cast_bent_rays(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const;
  /// Sets the facets of a ray's hit, where the bed is rippled.
  void set_facets(const BedPatch& bed, std::size_t lane, HitLanes& hits) const;
  /// Sets the echoes of up to sixteen rays; their energy is 0 where a ray meets nothing.
  void set_echoes(const Transmission& sent, const HitLanes& hits, std::span<RayEcho> echoes) const;
  BottomDetection detect(const Transmission& sent, std::size_t beam, const BeamEcho& echo) const;
  void record(const Transmission& sent, std::size_t beam, const BeamEcho& echo, const BottomDetection& found,
              AcousticPing& ping) const;
  void add_targets(const Transmission& sent, double time_s, OtherEchoes& others) const;
  void add_ghosts(const Transmission& sent, std::size_t first, std::size_t last, OtherEchoes& others) const;
  /// The power that a fluid reflects, by the cosine of the incidence in kMirrorSteps.
  static std::vector<float> mirror(const FluidBottom& fluid);
  double lost(const Transmission& sent, double depth_m, double path_m) const;
  double transmitted(double within_rad, double aside_rad) const;
  double received(std::size_t beam, double within_rad) const;
  double volume_at_1m(const Transmission& sent, std::size_t beam) const;
  double reverberation(const Transmission& sent, std::size_t beam, double range_m) const;
  /// Noise and reverberation in a beam, relative to the noise in an unsteered beam.
  double background(const Transmission& sent, std::size_t beam, double range_m) const;
  void record_water_column(const Transmission& sent, std::size_t beam, std::span<const RayEcho> surface,
                           std::span<const RayEcho> others, AcousticPing& ping) const;

  static constexpr int kMirrorSteps = 1000;

  MultibeamModel fan_;
  AcousticSpec spec_;
  RandomStream stream_;
  BeamFootprint footprint_;
  SoundSpeedProfile profile_;
  AbsorptionColumn absorption_;
  double volume_strength_;  ///< of the water per cubic metre, as a ratio; 0 if the water returns no echo
  double lossless_snr_db_;  ///< signal-to-noise ratio of a lossless echo, minus the model's gain
  BottomDetector detector_;
  SpeckleField speckle_;
  float share_sr_;   ///< solid angle of one ray of an unsteered beam
  float width_rad_;  ///< of an unsteered beam: the geometric mean of both widths
  /// By label, as ratios of intensity; the last entry applies to all further labels
  std::vector<float> strengths_, reliefs_;
  std::vector<ScatterCurve> curves_;
  std::vector<std::vector<float>> mirrors_;  // by label, see mirror
  bool by_angle_ = false;                    // whether any surface has a seabed's curve
  std::optional<RippledBed> ripples_;        // of the terrain
  std::vector<MovingTargets> targets_;
};

}  // namespace uwsim
