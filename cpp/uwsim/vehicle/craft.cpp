#include "uwsim/vehicle/craft.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d s;
  s << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return s;
}

/// Fossen (3.44): mass at r_g, inertia moved to the origin by the parallel-axis theorem.
Matrix6d rigid_body_mass(const CraftParameters& p) {
  const Eigen::Matrix3d s = cross_matrix(p.centre_of_mass_body_m);
  Matrix6d m;
  m << p.mass_kg * Eigen::Matrix3d::Identity(), -p.mass_kg * s, p.mass_kg * s, p.inertia_kg_m2 - p.mass_kg * s * s;
  return m;
}

/// C(nu) nu for the momentum p = M nu (Fossen 3.46, Kirchhoff's equations).
Vector6d coriolis(const Vector6d& momentum, const Vector6d& velocity) {
  const Eigen::Vector3d linear = momentum.head<3>(), angular = momentum.tail<3>();
  const Eigen::Vector3d v = velocity.head<3>(), w = velocity.tail<3>();
  Vector6d c;
  c << w.cross(linear), v.cross(linear) + w.cross(angular);
  return c;
}

double smallest_eigenvalue(const Matrix6d& m) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(0.5 * (m + m.transpose()), Eigen::EigenvaluesOnly).eigenvalues()(0);
}

}  // namespace

void CraftParameters::check() const {
  require(std::isfinite(mass_kg) && mass_kg > 0, "vehicle.mass_kg", mass_kg, "must be positive");
  require(centre_of_mass_body_m.allFinite(), "vehicle.centre_of_mass_m", centre_of_mass_body_m.transpose(),
          "must be finite");
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia_kg_m2, Eigen::EigenvaluesOnly).eigenvalues();
  require(inertia_kg_m2.allFinite() && principal(0) > 0 && principal(0) + principal(1) >= principal(2) * (1 - 1e-9),
          "vehicle.inertia_kg_m2", principal.transpose(),
          "principal moments must be positive and obey the triangle inequality");
  require(inertia_kg_m2.isApprox(inertia_kg_m2.transpose(), 1e-9), "vehicle.inertia_kg_m2", "asymmetric",
          "must be symmetric");
  for (const auto& [name, m] : {std::pair{"added_mass", &added_mass}, {"linear_damping", &linear_damping}}) {
    const std::string path = std::string("vehicle.") + name;
    require(m->allFinite(), path, "non-finite", "must be finite");
    const double low = smallest_eigenvalue(*m);
    require(low >= -1e-9 * m->cwiseAbs().maxCoeff(), path, low,
            "must be positive semi-definite (smallest eigenvalue shown)");
  }
  require(quadratic_damping.allFinite(), "vehicle.quadratic_damping", "non-finite", "must be finite");
  for (int i = 0; i < 6; ++i) {
    // v^T D (|v| v) >= 0 for every v, by Young's inequality a b^2 <= a^3 / 3 + 2 b^3 / 3 on each cross term.
    double cross = 0;
    for (int j = 0; j < 6; ++j) {
      if (j != i) cross += std::abs(quadratic_damping(i, j)) / 3 + 2 * std::abs(quadratic_damping(j, i)) / 3;
    }
    require(quadratic_damping(i, i) >= cross, "vehicle.quadratic_damping[" + std::to_string(i) + "]",
            quadratic_damping(i, i), "must not be negative nor less than its cross terms: drag takes energy away");
  }
  require(added_mass.isApprox(added_mass.transpose(), 1e-9) || added_mass.isZero(), "vehicle.added_mass", "asymmetric",
          "must be symmetric");
}

Craft::Craft(CraftParameters parameters, BuoyantHull hull)
    : parameters_(std::move(parameters)), hull_(std::move(hull)) {
  parameters_.check();
  rigid_mass_ = rigid_body_mass(parameters_);
  inverse_mass_under_ = (rigid_mass_ + parameters_.added_mass).llt().solve(Matrix6d::Identity());
}

Matrix6d Craft::inverse_mass_at(double submerged) const {
  if (submerged == 1) return inverse_mass_under_;
  return (rigid_mass_ + submerged * parameters_.added_mass).llt().solve(Matrix6d::Identity());
}

double Craft::submerged_fraction(const Pose& world_from_body) const {
  return std::clamp(hull_.displacement(world_from_body).volume_m3 / hull_.solid().volume_m3, 0.0, 1.0);
}

Matrix6d Craft::inverse_mass(const Pose& world_from_body) const {
  return inverse_mass_at(submerged_fraction(world_from_body));
}

Vector6d Craft::damping_body(const Vector6d& relative_velocity) const {
  return -(parameters_.linear_damping * relative_velocity +
           parameters_.quadratic_damping * relative_velocity.cwiseAbs().cwiseProduct(relative_velocity));
}

Vector6d Craft::acceleration_body(const BodyState& state, const Vector6d& tau_body, const Fluid& fluid) const {
  const Pose& pose = state.world_from_body;
  const Displacement wet = hull_.displacement(pose);
  const double submerged = std::clamp(wet.volume_m3 / hull_.solid().volume_m3, 0.0, 1.0);
  const Eigen::Matrix3d body_from_world = pose.rotation().transpose();
  const Eigen::Vector3d up_body = body_from_world.col(2);

  const Eigen::Vector3d weight = -parameters_.mass_kg * fluid.gravity_m_s2 * up_body;
  const Eigen::Vector3d lift = fluid.density_kg_m3 * fluid.gravity_m_s2 * wet.volume_m3 * up_body;
  const Eigen::Vector3d lift_arm = body_from_world * (wet.centroid_world_m - pose.position_m);
  Vector6d tau = tau_body;
  tau.head<3>() += weight + lift;
  tau.tail<3>() += parameters_.centre_of_mass_body_m.cross(weight) + lift_arm.cross(lift);

  const Vector6d& nu = state.velocity_body;
  const Eigen::Vector3d current = body_from_world * fluid.current_world_m_s;
  Vector6d relative = nu;
  relative.head<3>() -= current;
  Vector6d current_rate = Vector6d::Zero();  // a steady current seen from a turning body
  current_rate.head<3>() = -nu.tail<3>().cross(current);

  tau -= coriolis(rigid_mass_ * nu, nu);
  if (submerged > 0) {
    const Matrix6d& added = parameters_.added_mass;
    tau += submerged * (damping_body(relative) - coriolis(added * relative, relative) + added * current_rate);
  }
  if (submerged == 1) return inverse_mass_under_ * tau;
  return (rigid_mass_ + submerged * parameters_.added_mass).llt().solve(tau);
}

double Craft::kinetic_energy_j(const BodyState& state) const {
  const Matrix6d mass = rigid_mass_ + submerged_fraction(state.world_from_body) * parameters_.added_mass;
  return 0.5 * state.velocity_body.dot(mass * state.velocity_body);
}

}  // namespace uwsim
