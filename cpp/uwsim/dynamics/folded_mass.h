#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "uwsim/vehicle/hydrodynamics.h"

namespace uwsim {

/// The rigid body that best approximates a craft with its added mass. M_RB + s M_A, at the submerged fraction s, is
/// reduced to the parameters that physics engines support: a scalar mass and three moments of inertia about the centre
/// of mass.
///
/// The mass is m + s tr(A)/3, where A is the translational part of M_A: the mean over all directions. The moments are
/// the diagonal of the rotational part of M_RB + s M_A about the centre of mass, along its principal axes at s = 1. The
/// deviation of A from its mean and the coupling of translation and rotation about the centre of mass are lost. If both
/// are zero, the reduction is exact.
class FoldedMass {
 public:
  explicit FoldedMass(const CraftParameters& parameters);

  const Eigen::Vector3d& centre_of_mass_body_m() const { return centre_body_m_; }
  const Eigen::Quaterniond& body_from_principal() const { return body_from_principal_; }
  /// Returns true if the centre of mass and the principal axes are the same.
  bool has_axes_of(const FoldedMass& other) const {
    return centre_body_m_ == other.centre_body_m_ &&
           body_from_principal_.coeffs() == other.body_from_principal_.coeffs();
  }
  double mass_kg(double submerged) const { return mass_kg_ + submerged * added_kg_; }
  Eigen::Vector3d moments_kg_m2(double submerged) const { return moments_kg_m2_ + submerged * added_kg_m2_; }

  /// The wrench about the centre of mass, along the body's axes, with which this rigid body obeys M nu' = `load_body`
  /// [N, N m], where M is its own mass matrix. It compensates for the Coriolis and centripetal terms that the engine
  /// adds, because `load_body` already contains those of the craft (Craft::load).
  Vector6d applied_body(const Vector6d& load_body, const Vector6d& velocity_body, double submerged) const;

 private:
  Eigen::Vector3d centre_body_m_;
  Eigen::Quaterniond body_from_principal_;
  double mass_kg_, added_kg_;
  Eigen::Vector3d moments_kg_m2_, added_kg_m2_;  // along the principal axes
};

}  // namespace uwsim
