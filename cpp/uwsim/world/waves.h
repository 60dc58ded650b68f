#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/world/wave_sums.h"

namespace uwsim {

/// One linear wave: its surface height is a cos(k (x . direction) - omega t + phase).
struct WaveComponent {
  double amplitude_m = 0;
  double angular_frequency_rad_s = 1;
  double heading_rad = 0;  ///< direction of propagation, counter-clockwise from east
  double phase_rad = 0;
};

/// A sea defined by its spectrum (Hasselmann et al. 1973, "JONSWAP"; Bouws et al. 1985, J. Geophys. Res. 90(C1):975,
/// "TMA"): S(omega) is proportional to
///
///   omega^-5 exp(-1.25 (omega_p / omega)^4) gamma^b phi(omega),   b = exp(-(omega / omega_p - 1)^2 / (2 sigma^2)),
///
/// with sigma = 0.07 below the peak and 0.09 above it, and scaled so that the components together have exactly the
/// significant height (4 sqrt(m0)). phi = tanh(k h)^2 / (1 + 2 k h / sinh(2 k h)) is the factor of Kitaigorodskii et
/// al. 1975 (J. Phys. Oceanogr. 5:410), with which the spectrum in wave numbers does not depend on the depth: It is 1
/// in deep water, where this is the JONSWAP spectrum, and omega^2 h / (2 g) in shallow water, where it moves the peak
/// to slightly higher frequencies. For wind seas on water of constant depth. A test compares both spectra with the
/// package wavespectra 4.9.0.
///
/// The spectrum is truncated at about 11 omega_p, where the second moment m2 is 0.8 % too small, or at 42 rad/s, where
/// gravity waves end; for peak periods below 2 s, m2 is therefore smaller still. Each component has the energy and the
/// m2 of its share of the spectrum, so that the sums do not depend on the number of components. The shares are random,
/// and about equal in the mean of energy and m2. The tail, which has a tenth of m2 above 3 omega_p, therefore takes few
/// components, and no two frequencies are commensurable, so that the sea does not recur (evenly spaced frequencies
/// recur after 2 pi / spacing; 64 of them after 26 peak periods). A component that would break has a lower frequency
/// than its share: in the steepest seas, or with few components. Directions spread about the heading as cos^n
/// (DNV-RP-C205, 3.5.8); n = 0 is long-crested.
struct JonswapSea {
  double significant_height_m = 0.5;
  double peak_period_s = 4;
  double peak_enhancement = 3.3;  ///< gamma; the default is JONSWAP's mean
  double heading_rad = 0;
  double spreading_exponent = 0;
  int component_count = 64;
  std::uint64_t seed = 0;
};

/// The solution k of omega^2 = g k tanh(k h) [rad/m]. `depth_m` may be infinite.
double wave_number_rad_m(double angular_frequency_rad_s, double depth_m, double gravity_m_s2);

/// Motion of the water due to the waves alone, world frame.
struct WaveMotion {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d local_m_s2 = Eigen::Vector3d::Zero();       ///< du/dt of linear theory, due to its pressure
  Eigen::Vector3d convective_m_s2 = Eigen::Vector3d::Zero();  ///< the remaining acceleration of a particle
  double fade = 0;                                            ///< 0 at the surface, 1 where nothing is stretched
};

/// A sum of linear (Airy) waves on water of constant depth (Dean and Dalrymple 1991, ch. 3 and 4). Linear theory is
/// defined for z in [-h, 0] and is stretched near the surface: a point at z' between the surface eta and z = -D is
/// evaluated at z = D (z' - eta) / (D + eta), so that the pressure at the wave's own surface is atmospheric; below -D
/// it is evaluated at z' itself. This is delta stretching (Rodenbusch and Forristall 1986, OTC 5246) with Delta = 0,
/// which is Wheeler's (1970) method confined to a layer, and with their D of half the significant height, but at least
/// twice the depth of the present trough. Wheeler's original, which stretches down to the bed, has a mean velocity
/// against the waves of a^2 omega k exp(k z) / 2, which exceeds the Stokes drift below k z = -0.7.
///
/// To second order, particles in deep water drift with the waves at a^2 omega k exp(2 k z) (Stokes 1847) and do not
/// drift vertically. So that a body that moves with the water keeps doing so, the acceleration is that of the
/// particles, including the convective part (u . grad) u, whose pressure is the Bernoulli term -rho u^2 / 2. A current
/// carries the particles through the waves, but does not shift the wave frequencies: valid for currents that are slow
/// compared with the phase speed. Second-order waves at sums and differences of frequencies are not modelled, nor is
/// return flow.
///
/// Valid for small steepness, which is bounded by the sum of the slopes (a wave higher than 0.142 wavelengths, k a =
/// 0.45, would break), and only above the bed at z = -depth_m.
class Waves {
 public:
  static constexpr std::size_t kMaxComponents = 512;
  static constexpr double kSteepest = 0.45;  ///< amplitude times wave number; a steeper wave breaks

  /// Throws InvalidValue naming water.surface.
  Waves(std::span<const WaveComponent> components, double depth_m, double gravity_m_s2 = 9.80665);
  static Waves jonswap(const JonswapSea& sea, double depth_m, double gravity_m_s2 = 9.80665);

  /// Sum of the amplitudes: no crest is higher and no trough deeper.
  double bound_m() const { return bound_m_; }
  double depth_m() const { return depth_m_; }
  /// 4 sqrt(m0) of the components [m].
  double significant_height_m() const;
  std::vector<WaveComponent> components() const;

  double height_at(double x_world_m, double y_world_m, double time_s) const;
  /// The effect of waves that are short compared with the area fades out, as in add_flow_over.
  WaterSurface surface_over(const SurfaceArea& area, double time_s) const;
  /// Pressure head (WaterField::pressure_head_at): eta K(z) - z, where K is the decay of the waves' pressure with
  /// depth; above the surface, eta - z. First-order: see bernoulli_head_at for the second-order part.
  double head_at(const Eigen::Vector3d& point_world_m, double time_s) const;
  /// The second-order part of the pressure head, -u^2 / (2 g). It fades out towards the surface, where stretching
  /// lowers the mean pressure by the same amount.
  double bernoulli_head_at(const Eigen::Vector3d& point_world_m, double time_s) const;
  /// Adds velocity and acceleration of the orbital motion to a flow that contains the current.
  void add_flow(const Eigen::Vector3d& point_world_m, double time_s, WaterFlow& flow) const;
  /// The same without waves of which less than 1e-3 remains at that depth. With `surface_m`, sets it to the surface's
  /// height, and adds nothing if the point is at least `emerged_m` above that.
  void add_main_flow(const Eigen::Vector3d& point_world_m, double time_s, WaterFlow& flow, double emerged_m,
                     double* surface_m) const;
  /// The motion of a particle that is carried along by a current.
  WaveMotion motion_at(const Eigen::Vector3d& point_world_m, double time_s, const Eigen::Vector3d& current_m_s) const;
  /// The same for WaterField::flow_over. The volume is cut into up to eight slices, none of which is longer than a
  /// third of the shortest wave that matters at its depth. The effect of waves along the volume that are shorter than
  /// 0.4 times its length fades out: their crests and troughs nearly cancel.
  void add_flow_over(const PlacedVolume& volume, double time_s, VolumeFlow& flow) const;
  /// WaterField::wave_load_on: the integrals over the volume of -g grad h and of its moment, where h is the waves'
  /// pressure head, stretched. The stretching is assumed linear over the volume.
  VolumeLoad load_on(const VolumePart& wet_world, const WaterSurface& surface, double time_s) const;
  /// The horizontal displacement x of what the waves at a point move and a spring holds: dx/dt = u - rate x, without
  /// its start. At a rate of 0, it is the displacement of the water itself.
  Eigen::Vector2d held_m(const Eigen::Vector3d& point_world_m, double time_s, double rate_1_s) const;
  /// The mean square of the horizontal velocity at a depth [m2/s2].
  double mean_square_m2_s2(double z_world_m) const;
  /// WaterField::division_of
  std::size_t division_of(const VolumeParts& parts, double centre_z_m) const;

 private:
  static constexpr double kTroughs = 2;  // depth of the stretched layer in units of the trough's depth
  static constexpr double kLeftOut =
      0.02;  // fraction of the energy in the shortest waves, which slices need not resolve

  struct Wave {
    double amplitude_m, omega_rad_s, number_rad_m, number_x_rad_m, number_y_rad_m, phase_rad;
    double deep;     // 1 / (1 + exp(-2 k h)): weight of exp(k z) in cosh(k (z + h)) / cosh(k h); 1 in deep water
    double shallow;  // 1 / tanh(k h): velocity relative to pressure; 1 in deep water
  };
  using Crests = std::array<CrestBlock, kMaxComponents / WaveBlock::kLanes>;
  /// The height at which linear theory is evaluated for a point, and its derivatives with respect to the heights of the
  /// point and the surface.
  struct Stretched {
    double z_m, by_point, by_surface;
  };
  static Eigen::Vector3d convective(const WaveMotionSums& sums, const Stretched& at,
                                    const Eigen::Vector3d& current_m_s);
  void put_into_blocks();
  /// Number of blocks, counted from the longest waves, whose motion reaches `z_m`: `depths` times 1 / k.
  std::size_t count_reaching(double z_m, double depths) const;
  std::size_t count_reaching(double z_m) const;
  WaveMotion motion_of(const Crests& crests, double height_m, std::size_t count, const Eigen::Vector3d& point_m,
                       const Eigen::Vector3d& current_m_s) const;
  double crests_at(double x, double y, double time_s, std::size_t count, Crests& crests) const;
  /// Horizontal velocity at a depth, for each metre of the surface's height.
  double speed_1_s(const Wave& wave, double z_world_m) const;
  /// Depth D of the stretched layer for a surface height of `height_m`.
  double layer_m(double height_m) const;
  Stretched stretched(double z_m, double height_m) const;
  double unstretched(double z_m, double height_m) const { return stretched(z_m, height_m).z_m; }

  std::vector<Wave> waves_;        // longest first
  std::vector<WaveBlock> blocks_;  // the same
  double depth_m_;
  double gravity_m_s2_;
  double bound_m_ = 0;
  double stretched_m_ = 0;     // D unless a trough is deep
  double resolved_rad_m_ = 0;  // wave number of the shortest wave, leaving out kLeftOut of the energy
  double slope_ = 0;           // upper bound of the surface's slope: sum of a k
};

}  // namespace uwsim
