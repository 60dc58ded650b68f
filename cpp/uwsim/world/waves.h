#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"

namespace uwsim {

/// One linear wave: height a cos(k (x . direction) - omega t + phase).
struct WaveComponent {
  double amplitude_m = 0;
  double angular_frequency_rad_s = 1;
  double heading_rad = 0;  ///< towards which it runs, from east, counter-clockwise
  double phase_rad = 0;
};

/// A sea by its spectrum (Hasselmann et al. 1973, "JONSWAP"): S(omega) as omega^-5 exp(-1.25 (omega_p / omega)^4)
/// gamma^b, b = exp(-(omega / omega_p - 1)^2 / (2 sigma^2)), sigma 0.07 below the peak and 0.09 above, scaled so that
/// the components together have the significant height exactly (4 sqrt(m0)). Spreading cos^n about the heading
/// (DNV-RP-C205, 3.5.8), 0 for long-crested.
struct JonswapSea {
  double significant_height_m = 0.5;
  double peak_period_s = 4;
  double peak_enhancement = 3.3;  ///< gamma, JONSWAP's mean
  double heading_rad = 0;
  double spreading_exponent = 0;
  int component_count = 64;
  std::uint64_t seed = 0;
};

/// omega^2 = g k tanh(k h), solved for k [rad/m]. `depth_m` may be infinite.
double wave_number_rad_m(double angular_frequency_rad_s, double depth_m, double gravity_m_s2);

/// Linear (Airy) waves on water of constant depth, summed (Dean and Dalrymple 1991, ch. 3 and 4). Near the surface by
/// Wheeler's stretching (1970): what linear theory says of z in [-h, 0] is taken at z = (z' - eta) h / (h + eta), so
/// that pressure is the atmosphere's at the wave's own surface. Valid for small steepness: the slopes' sum bounds it,
/// and waves steeper than 0.142 wave lengths (k a = 0.44) would break. Above the bed at z = -depth_m only.
class Waves {
 public:
  static constexpr std::size_t kMost = 512;  ///< components

  /// Throws InvalidValue, naming water.surface.
  Waves(std::span<const WaveComponent> components, double depth_m, double gravity_m_s2 = 9.80665);
  static Waves jonswap(const JonswapSea& sea, double depth_m, double gravity_m_s2 = 9.80665);

  double bound_m() const { return bound_m_; }
  double depth_m() const { return depth_m_; }
  /// 4 sqrt(m0) of its components [m].
  double significant_height_m() const;
  std::vector<WaveComponent> components() const;

  double height_at(double x_world_m, double y_world_m, double time_s) const;
  SurfaceSpan span_at(double x_world_m, double y_world_m, double radius_m, double time_s) const;
  /// eta K(z) - z, K the decay of pressure with depth; above the surface eta - z.
  double head_at(const Eigen::Vector3d& point_world_m, double time_s) const;
  /// Of many points together: where they are close together against the waves' lengths, by one polynomial for all,
  /// within 5e-4 of the amplitudes' sum.
  void heads(std::span<const Eigen::Vector3d> points_world_m, double time_s, std::span<double> heads_m) const;
  /// Adds the orbits' velocity and local acceleration.
  void add_flow(const Eigen::Vector3d& point_world_m, double time_s, WaterFlow& flow) const;
  WaveLoad load(const Eigen::Vector3d& centroid_world_m, double volume_m3, const Eigen::Matrix3d& second_moment_m5,
                double time_s) const;

 private:
  struct Wave {
    double amplitude_m, omega_rad_s, number_rad_m, number_x_rad_m, number_y_rad_m, phase_rad;
    double deep;     // 1 / (1 + exp(-2 k h)): the share of the upper exponential of cosh(k (z + h)) / cosh(k h)
    double shallow;  // 1 / tanh(k h): of velocity over pressure
  };
  struct Crest {
    double cosine, sine;  // of the phase, times the amplitude
  };
  /// Number of waves, long ones first, that are felt at a depth of `z_m` below the troughs.
  std::size_t felt_at(double z_m) const;
  double crests_at(double x, double y, double time_s, std::size_t count, Crest* crests) const;
  double unstretched(double z_m, double height_m) const;
  int patch_order(double radius_m) const;
  template <int kOrder>
  void patch_heads(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre, double time_s,
                   std::span<double> heads_m) const;

  std::vector<Wave> waves_;  // longest first
  double depth_m_;
  double gravity_m_s2_;
  double bound_m_ = 0;
  double slope_ = 0;
  std::array<double, 11> moments_{};  // sum of a k^n, n = 0 .. 10
};

}  // namespace uwsim
