#pragma once

#include <Eigen/Core>

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/buoyant_hull.h"

namespace uwsim {

/// What a craft is made of. Six-vectors and 6x6 matrices in Fossen's order (surge, sway, heave, roll, pitch, yaw), body
/// frame, about the body's origin.
struct CraftParameters {
  double mass_kg = 0;
  Eigen::Vector3d centre_of_mass_body_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of mass
  Matrix6d added_mass = Matrix6d::Zero();                   ///< M_A [kg, kg m, kg m^2]
  Matrix6d linear_damping = Matrix6d::Zero();               ///< D_l [N s/m, ...]
  Matrix6d quadratic_damping = Matrix6d::Zero();            ///< D_q, force = -D_q (|nu| nu) [N s^2/m^2, ...]

  /// Throws InvalidValue that names the field: masses positive, M_RB + M_A positive definite, damping dissipative.
  void check() const;
};

/// Equations of motion of a rigid body in fluid (Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion
/// Control", ch. 6 and 8):
///
///   (M_RB + M_A) nu' = tau + g(eta) - C_RB(nu) nu - C_A(nu_r) nu_r - D(|nu_r|) nu_r + M_A nu_c' + F_c
///
/// with nu_r = nu - nu_c the velocity relative to the water, D = D_l + D_q |nu_r|, C from M by Kirchhoff (3.46),
/// restoring forces g from gravity and from the water's pressure on the hull, waves included (BuoyantHull).
/// nu_c is the water's velocity, current and waves' orbits, at the centre of what is submerged: as if uniform over the
/// hull, so for a hull shorter than a quarter of the wave and of the current's shear. nu_c' is its rate seen from the
/// body: the turning of the body and the water's local acceleration; that a body drifts through a velocity that differs
/// from place to place (second order) is left out. F_c = rho V a_c is the pressure that drives an unsteady current;
/// that of waves is in g (Froude-Krylov). No radiation damping, no diffraction beyond M_A. Added mass and damping scale
/// with the submerged fraction of the hull. For constant coefficients, deeply submerged or slowly surfacing.
class Craft {
 public:
  /// Throws InvalidValue from the parameters' and the hull's checks, and where the centre of mass is beside the hull.
  Craft(CraftParameters parameters, BuoyantHull hull);

  const CraftParameters& parameters() const { return parameters_; }
  const BuoyantHull& hull() const { return hull_; }

  /// nu' [m/s^2, rad/s^2] under the external wrench `tau_body` (actuators), body frame at the origin, in the water at
  /// `time_s`.
  Vector6d acceleration_body(const BodyState& state, const Vector6d& tau_body, const WaterField& water,
                             double time_s) const;
  /// (M_RB + M_A)^-1 at this pose; contacts are solved with it.
  Matrix6d inverse_mass(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// 0 dry .. 1 fully under the water's height over the hull.
  double submerged_fraction(const Pose& world_from_body, const WaterField& water, double time_s) const;
  /// Kinetic energy 1/2 nu^T (M_RB + M_A) nu of the body and the still water around it, its surface at z = 0 [J].
  double kinetic_energy_j(const BodyState& state) const;

 private:
  double fraction(double wet_volume_m3) const;
  Vector6d damping_body(const Vector6d& relative_velocity) const;
  Vector6d flow_force_body(const Vector6d& velocity, const WaterFlow& flow, const Eigen::Matrix3d& world_from_body,
                           const Buoyancy& lift, double submerged, double density_kg_m3) const;
  Matrix6d inverse_mass_at(double submerged) const;

  CraftParameters parameters_;
  BuoyantHull hull_;
  Matrix6d rigid_mass_;          // M_RB
  Matrix6d inverse_mass_under_;  // (M_RB + M_A)^-1
};

}  // namespace uwsim
