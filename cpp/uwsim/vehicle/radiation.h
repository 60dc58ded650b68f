#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/volume_parts.h"

namespace uwsim {

/// The effect on a floating hull of the waves that it makes, linear in its motion and in the sea (Newman 1977, "Marine
/// Hydrodynamics", sec. 6.15 to 6.19): the numbers of a panel code's table, about the body's origin, body frame.
///
/// Radiation is Cummins' equation (1962, Schiffstechnik 47:101): the hull carries the infinite-frequency added mass,
/// and the rest of the force is a convolution over its past velocity, -int K(t - tau) nu(tau) dtau. The transform of K
/// is rational, with poles common to all motions: the sum over k of (R_k s + Q_k) / (s^2 + 2 zeta_k omega_k s +
/// omega_k^2), which check() requires to be what Perez and Fossen (2009, Modeling, Identification and Control 30:1)
/// list: stable, of relative degree one, without memory of a steady velocity, and passive, that is, with a real part at
/// s = i omega that is positive semi-definite, so that the waves only take energy.
///
/// Diffraction is the force on the fixed hull beyond the pressure of the undisturbed waves as BuoyantHull has it, which
/// depends on the division of the hull into slices. The force of a wave a cos(k . x - omega t + phase) on a hull at x
/// is a Re(X exp(i (k . x - omega t + phase))).
///
/// The slow horizontal force of second order is, likewise, what the pressure and the terms above lack of the mean drift
/// D a^2 of a free hull in regular waves. In a sea it is Newman's approximation (1974, "Second-order, slowly-varying
/// forces on vessels in irregular waves"), with (D_i + D_j) / 2 for the waves i and j: the sum over both of a_i a_j D_i
/// cos(phase_i - phase_j). Its mean is exact to second order; it varies as it should if D changes little between waves
/// whose frequencies differ by as much as the hull's slow motions.
///
/// Valid for small motions about the floating pose, a slow hull (its speed much less than the waves') and the depth of
/// the table. The terms are weighted by share(), beyond which the model of a submerged hull takes over.
struct Radiation {
  /// Resonators of one frequency, each driven by the velocity along or about an axis. The force of their displacements
  /// y on the hull is -(by_speed y' + by_place y).
  struct Section {
    Matrix6d by_speed = Matrix6d::Zero();  ///< R [kg/s^2, kg m/s^2, kg m^2/s^2]
    Matrix6d by_place = Matrix6d::Zero();  ///< Q, those per second
    double omega_rad_s = 1, damping_ratio = 0.5;
  };
  static constexpr std::size_t kDivisions = std::tuple_size_v<decltype(VolumeParts::slices)>;
  using Force = Eigen::Matrix<double, 6, 2>;  ///< real and imaginary part of X [N/m, N]
  using Drift = Eigen::Vector3d;              ///< along x, along y, about z [N/m^2, N/m]

  Matrix6d added_mass = Matrix6d::Zero();  ///< at infinite frequency [kg, kg m, kg m^2]
  std::vector<Section> sections;
  /// For each division into slices (VolumeParts::slices), X at `frequencies` evenly spaced frequencies from
  /// `least_rad_s` to `most_rad_s`, for each of them at `headings` evenly spaced directions in which the wave travels,
  /// from the body's x counter-clockwise.
  std::vector<Force> diffraction;
  std::vector<Drift> drift;  ///< D likewise; empty: none is modelled
  std::size_t frequencies = 0, headings = 0;
  double least_rad_s = 0, most_rad_s = 0;
  double wet_volume_m3 = 0;  ///< of the floating hull

  /// Throws InvalidValue naming the field.
  void check() const;
  /// K at s [N s/m, ...]: at i omega, it is B + i omega (A - A_infinity) of the table.
  Eigen::Matrix<std::complex<double>, 6, 6> impedance(std::complex<double> s) const;
  /// X of a hull in that division, linear between frequencies and headings. Beyond the table it falls with the square
  /// of the frequency to either side, as the force on a hull does in very long waves.
  Force diffraction_at(std::size_t division, double omega_rad_s, double heading_rad) const;
  /// D of a hull in that division, likewise.
  Drift drift_at(std::size_t division, double omega_rad_s, double heading_rad) const;
  /// The weight of these terms, from 0 to 1: 1 for a floating hull. It falls to 0 as the hull leaves the water, from
  /// half its floating volume; as it capsizes, between tilts of 30 and 60 degrees; and as it dives, until its top is
  /// half a hull's length below the surface. `up`: cosine of its tilt. `cover`: depth of its top under the surface over
  /// that length.
  double share(double submerged_volume_m3, double up, double cover) const;

 private:
  void check_sections() const;
  template <class Value>
  Value between(const std::vector<Value>& values, std::size_t division, double omega_rad_s, double heading_rad) const;
};

}  // namespace uwsim
