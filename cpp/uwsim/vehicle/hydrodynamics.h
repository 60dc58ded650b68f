#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/buoyant_hull.h"
#include "uwsim/vehicle/crossflow_drag.h"

namespace uwsim {

/// Mass and hydrodynamic coefficients of a craft. Six-vectors and 6x6 matrices are in Fossen's order (surge, sway,
/// heave, roll, pitch, yaw), in the body frame, about the body's origin.
struct CraftParameters {
  double mass_kg = 0;
  Eigen::Vector3d centre_of_mass_body_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of mass
  Matrix6d added_mass = Matrix6d::Zero();                   ///< M_A [kg, kg m, kg m^2]
  Matrix6d linear_damping = Matrix6d::Zero();               ///< D_l [N s/m, ...]
  Matrix6d quadratic_damping = Matrix6d::Zero();            ///< D_q, force = -D_q (|nu| nu) [N s^2/m^2, ...]

  double munk_share = 1;  ///< share of the Munk moment remaining in separated flow, 0 to 1; 1 in an ideal fluid
  /// Submerged volume at which added mass and damping hold; with less of the hull in the water they fall in proportion,
  /// with more they stay. 0: that of the whole hull.
  double coefficients_volume_m3 = 0;
  double crossflow_length_m = 0;  ///< length along x over which sway and heave drag is spread; 0: at the origin

  /// Buoyancy as a fraction of rho(z) g V, with the density at atmospheric pressure and the volume at the surface.
  /// Values at depths 0, `buoyancy_share_step_m`, twice that, and so on; linear in between and constant below the last.
  /// Empty: 1 at all depths, for a hull that compresses like the water around it.
  std::vector<double> buoyancy_share;
  double buoyancy_share_step_m = 0;  ///< [m]

  double buoyancy_share_at(double depth_m) const;
  /// The drag of the strips, in heave and pitch or in sway and yaw.
  CrossflowDrag crossflow_in_heave() const;
  CrossflowDrag crossflow_in_sway() const;
  /// Throws InvalidValue naming the field unless masses are positive, M_RB + M_A is positive definite and damping is
  /// dissipative.
  void check() const;
};

/// A matrix of coefficients. Most vehicles have diagonal ones, whose product takes a sixth of the work.
class Coefficients {
 public:
  Coefficients() = default;
  explicit Coefficients(const Matrix6d& all)
      : all_(all), diagonal_(all.diagonal()), is_diagonal_(all.isApprox(Matrix6d(diagonal_.asDiagonal()), 0)) {}

  /// The same value either way: adding 0 gives a zero the sign that the sum of a row would have.
  [[gnu::always_inline]] Vector6d operator*(const Vector6d& x) const {
    return is_diagonal_ ? Vector6d(diagonal_.cwiseProduct(x) + Vector6d::Zero()) : product(x);
  }

 private:
  [[gnu::noinline]] Vector6d product(const Vector6d& x) const { return all_ * x; }

  Matrix6d all_ = Matrix6d::Zero();
  Vector6d diagonal_ = Vector6d::Zero();
  bool is_diagonal_ = true;
};

/// A craft: a rigid body in a fluid, with its equations of motion (Fossen 2011, "Handbook of Marine Craft Hydrodynamics
/// and Motion Control", ch. 6 and 8):
///
///   (M_RB + M_A) nu' = tau + g(eta) - C_RB(nu) nu - C_A(nu_r) nu_r - D(|nu_r|) nu_r + M_A nu_c' + F_c
///
/// where nu_r = nu - nu_c is the velocity relative to the water, D = D_l + D_q |nu_r|, C follows from M by Kirchhoff's
/// equations (3.46), and the restoring forces g are gravity and the water's pressure on the hull, including waves
/// (BuoyantHull). The drag in sway and in heave may be spread along the hull (CrossflowDrag).
///
/// The Munk moment v x A v (Munk 1924, NACA Report 184), where A is the translational part of M_A, assumes an ideal
/// fluid, which closes behind the body. Where the flow separates, the stern's contribution is lost (Hopkins 1951, NACA
/// RM A51C14); on a sharp-edged frame, the bow's contribution is lost, too. C_A therefore uses s A + (1 - s) tr(A)/3 in
/// place of A, with s = munk_share: only the deviatoric part of A turns the body. C_A remains skew-symmetric, so it
/// does no work for any s; with s < 1 the wake carries momentum away. Fossen omits such entries in the same pairs
/// (PythonVehicleSimulator, remus100.py).
///
/// nu_c is the motion of the water (current and orbital wave motion), expressed as that of a rigid body with the linear
/// and angular momentum of the water that the hull would displace if it were moved to the centre of its submerged
/// volume. For a slender hull with the added mass of its sections, this is strip theory (Newman 1977, "Marine
/// Hydrodynamics", sec. 7.5): forces and moments along the hull vary with the waves, which may be as short as the hull.
/// nu_c' is the rate of change of nu_c in the body frame, due to the rotation of the body and the water's acceleration.
/// For waves, this is the acceleration of the particles, including the convective part (Auton, Hunt and Prud'homme
/// 1988, J. Fluid Mech. 197:241), so that a neutrally buoyant body that moves with the water keeps doing so. For
/// currents, it is the local acceleration, without the second-order part due to drifting through a velocity field that
/// varies in space.
///
/// F_c = rho V a_c is the force of the pressure gradient that drives an unsteady current; the pressure of waves is part
/// of g (Froude-Krylov). Added mass and damping scale with the submerged fraction of the hull. Valid for constant
/// coefficients, deeply submerged or slowly surfacing: radiation damping is not modelled, nor is diffraction beyond
/// M_A.
class Craft {
 public:
  /// Throws InvalidValue if the parameters are invalid or the centre of mass is outside the hull's bounding box.
  Craft(CraftParameters parameters, std::shared_ptr<const BuoyantHull> hull);
  Craft(CraftParameters parameters, BuoyantHull hull);

  const CraftParameters& parameters() const { return parameters_; }
  const BuoyantHull& hull() const { return *hull_; }

  /// The right-hand side of the equations of motion, tau + g - C_RB nu - ... + F_c, body frame, at the origin [N, N m].
  struct Load {
    Vector6d wrench_body;
    double submerged;  ///< the submerged fraction
  };
  Load load(const BodyState& state, const Vector6d& tau_body, const WaterField& water, double time_s) const {
    return load(state, tau_body, water, time_s, nullptr, nullptr);
  }
  /// The terms that move the rigid body, apart from actuators and contacts, body frame, at the origin [N, N m]. With
  /// these, their sum is M_RB nu'.
  struct Terms {
    Vector6d weight = Vector6d::Zero();
    Vector6d buoyancy = Vector6d::Zero();    ///< the pressure of the water around, with waves and F_c
    Vector6d drag = Vector6d::Zero();        ///< -D(|nu_r|) nu_r
    Vector6d added_mass = Vector6d::Zero();  ///< -M_A (nu' - nu_c') - C_A(nu_r) nu_r
    Vector6d coriolis = Vector6d::Zero();    ///< -C_RB(nu) nu: the axes turn with the body
  };
  /// The terms for a body that accelerates at `acceleration_body`, nu'.
  Terms terms(const BodyState& state, const Vector6d& acceleration_body, const WaterField& water, double time_s,
              NearbyWater* nearby = nullptr) const;
  /// M_RB.
  const Matrix6d& rigid_mass() const { return rigid_mass_; }
  /// nu' [m/s^2, rad/s^2] under the actuators' wrench `tau_body` (body frame, at the origin) in the water at `time_s`.
  /// `nearby`: as in BuoyantHull::buoyancy.
  Vector6d acceleration_body(const BodyState& state, const Vector6d& tau_body, const WaterField& water, double time_s,
                             NearbyWater* nearby = nullptr) const;
  /// The mass with that of the water, M_RB + M_A, at this share.
  Matrix6d mass(double submerged) const { return rigid_mass_ + submerged * parameters_.added_mass; }
  /// (M_RB + M_A)^-1 at this pose, for the contact solver.
  Matrix6d inverse_mass(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// The submerged fraction, from 0 (dry) to 1 (entirely below the water level over the hull).
  double submerged_fraction(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// Kinetic energy 1/2 nu^T (M_RB + M_A) nu of the body and the surrounding still water, with the water's surface at z
  /// = 0 [J].
  double kinetic_energy_j(const BodyState& state) const;

 private:
  Load load(const BodyState& state, const Vector6d& tau_body, const WaterField& water, double time_s,
            NearbyWater* nearby, Terms* terms) const;
  double fraction(double wet_volume_m3) const;
  Vector6d damping_body(const Vector6d& relative_velocity) const;
  Vector6d flow_force_body(const Vector6d& velocity, const Eigen::Matrix3d& world_from_body, const Buoyancy& buoyancy,
                           double submerged, double density_kg_m3, Terms* terms) const;
  Vector6d inverse_mass_of_modes(double submerged) const;
  Matrix6d inverse_mass_at(double submerged) const;

  CraftParameters parameters_;
  std::shared_ptr<const BuoyantHull> hull_;
  Matrix6d rigid_mass_;                           // M_RB
  Coefficients momentum_of_, inverse_submerged_;  // M_RB; (M_RB + M_A)^-1
  Coefficients linear_damping_, added_mass_;
  Coefficients coriolis_added_mass_;  // M_A as used in C_A
  Coefficients point_damping_;        // D_q without the drag of the strips
  CrossflowDrag heave_strips_, sway_strips_;
  Matrix6d inverse_mass_submerged_;  // (M_RB + M_A)^-1
  // W and L such that W^T M_RB W = 1 and W^T M_A W = diag(L), and hence (M_RB + s M_A)^-1 = W diag(1 / (1 + s L)) W^T
  // for any submerged fraction s.
  Matrix6d mass_modes_;
  Vector6d added_mass_of_modes_;
};

}  // namespace uwsim
