#pragma once

#include <Eigen/Core>

#include "uwsim/core/body_state.h"
#include "uwsim/vehicle/buoyant_hull.h"
#include "uwsim/vehicle/fluid.h"

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
///   (M_RB + M_A) nu' = tau + g(eta) - C_RB(nu) nu - C_A(nu_r) nu_r - D(|nu_r|) nu_r + M_A nu_c'
///
/// with nu_r = nu - nu_c the velocity relative to a uniform current, D = D_l + D_q |nu_r|, C from M by Kirchhoff
/// (3.46), restoring forces g from gravity and from the hull cut at the water surface. Added mass and damping scale
/// with the submerged fraction of the hull. Valid for a deeply submerged or slowly surfacing body of constant
/// coefficients.
class Craft {
 public:
  /// Throws InvalidValue from the parameters' and the hull's checks.
  Craft(CraftParameters parameters, BuoyantHull hull);

  const CraftParameters& parameters() const { return parameters_; }
  const BuoyantHull& hull() const { return hull_; }

  /// nu' [m/s^2, rad/s^2] under the external wrench `tau_body` (actuators), body frame at the origin.
  Vector6d acceleration_body(const BodyState& state, const Vector6d& tau_body, const Fluid& fluid) const;
  /// (M_RB + M_A)^-1 at this pose; contacts are solved with it.
  Matrix6d inverse_mass(const Pose& world_from_body) const;
  /// 0 dry .. 1 fully under water.
  double submerged_fraction(const Pose& world_from_body) const;
  /// Kinetic energy 1/2 nu^T (M_RB + M_A) nu of the body and the still water around it [J].
  double kinetic_energy_j(const BodyState& state) const;

 private:
  Vector6d damping_body(const Vector6d& relative_velocity) const;
  Matrix6d inverse_mass_at(double submerged) const;

  CraftParameters parameters_;
  BuoyantHull hull_;
  Matrix6d rigid_mass_;          // M_RB
  Matrix6d inverse_mass_under_;  // (M_RB + M_A)^-1
};

}  // namespace uwsim
