#include "uwsim/dynamics/folded_mass.h"
#include "uwsim/core/symmetric.h"

namespace uwsim {
namespace {

/// The rotational part of a 6x6 mass about the origin, about another point.
Eigen::Matrix3d rotational_about(const Eigen::Vector3d& point_m, const Matrix6d& mass) {
  // A turn w about the point moves the origin by point x w.
  Eigen::Matrix<double, 6, 3> turn;
  turn.topRows<3>() << 0, -point_m.z(), point_m.y(), point_m.z(), 0, -point_m.x(), -point_m.y(), point_m.x(), 0;
  turn.bottomRows<3>().setIdentity();
  const Eigen::Matrix3d about = turn.transpose() * mass * turn;
  return 0.5 * (about + about.transpose());
}

}  // namespace

FoldedMass::FoldedMass(const CraftParameters& p)
    : centre_body_m_(p.centre_of_mass_body_m),
      mass_kg_(p.mass_kg),
      added_kg_(p.added_mass.topLeftCorner<3, 3>().trace() / 3) {
  const Eigen::Matrix3d added = rotational_about(centre_body_m_, p.added_mass);
  Eigen::Matrix3d axes = principal_axes(p.inertia_kg_m2 + added).vectors;
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  body_from_principal_ = Eigen::Quaterniond(axes);
  moments_kg_m2_ = (axes.transpose() * p.inertia_kg_m2 * axes).diagonal();
  added_kg_m2_ = (axes.transpose() * added * axes).diagonal();
}

Vector6d FoldedMass::applied_body(const Vector6d& load_body, const Vector6d& velocity_body, double submerged) const {
  const Eigen::Vector3d v = velocity_body.head<3>(), w = velocity_body.tail<3>();
  const Eigen::Vector3d momentum = mass_kg(submerged) * (v + w.cross(centre_body_m_));
  const Eigen::Vector3d spin =
      body_from_principal_ *
      moments_kg_m2(submerged).cwiseProduct(body_from_principal_.conjugate() * w);  // about the centre of mass
  const Eigen::Vector3d force = load_body.head<3>() + w.cross(momentum);
  const Eigen::Vector3d moment =
      load_body.tail<3>() + v.cross(momentum) + w.cross(spin + centre_body_m_.cross(momentum));  // about the origin
  Vector6d applied;
  applied << force, moment - centre_body_m_.cross(force);
  return applied;
}

}  // namespace uwsim
