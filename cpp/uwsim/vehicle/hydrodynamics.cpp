#include "uwsim/vehicle/hydrodynamics.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"

namespace uwsim {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d s;
  s << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return s;
}

/// M_RB about the origin (Fossen 3.44); the inertia is transferred there by the parallel-axis theorem.
Matrix6d rigid_body_mass(const CraftParameters& p) {
  const Eigen::Matrix3d s = cross_matrix(p.centre_of_mass_body_m);
  Matrix6d m;
  m << p.mass_kg * Eigen::Matrix3d::Identity(), -p.mass_kg * s, p.mass_kg * s, p.inertia_kg_m2 - p.mass_kg * s * s;
  return m;
}

/// C(nu) nu for the momentum M nu (Kirchhoff's equations, Fossen 3.46).
Vector6d coriolis(const Vector6d& momentum, const Vector6d& velocity) {
  const Eigen::Vector3d linear = momentum.head<3>(), angular = momentum.tail<3>();
  const Eigen::Vector3d v = velocity.head<3>(), w = velocity.tail<3>();
  return joined(w.cross(linear), v.cross(linear) + w.cross(angular));
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> box_of(const TriangleMesh& hull) {
  Eigen::Vector3d low = hull.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : hull.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return {low, high};
}

/// A body's centre of mass must be inside its bounding box.
void require_inside_box(const Eigen::Vector3d& centre_of_mass_m, const TriangleMesh& hull) {
  const auto [low, high] = box_of(hull);
  const bool inside =
      (centre_of_mass_m.array() >= low.array()).all() && (centre_of_mass_m.array() <= high.array()).all();
  if (inside) return;
  std::ostringstream rule;
  rule << "must be in the hull's bounding box, from (" << low.transpose() << ") to (" << high.transpose() << ") m";
  require(false, "vehicle.centre_of_mass_m", centre_of_mass_m.transpose(), rule.str());
}

/// M_A as it is used in C_A: s A + (1 - s) tr(A)/3 in place of its translational part A.
Matrix6d with_munk_share(Matrix6d added_mass, double munk_share) {
  const Eigen::Matrix3d isotropic = added_mass.topLeftCorner<3, 3>().trace() / 3 * Eigen::Matrix3d::Identity();
  added_mass.topLeftCorner<3, 3>() *= munk_share;
  added_mass.topLeftCorner<3, 3>() += (1 - munk_share) * isotropic;
  return added_mass;
}

double smallest_eigenvalue(const Matrix6d& m) { return eigenvalues(Matrix6d(0.5 * (m + m.transpose())))(0); }

/// Returns true if the water moves as a whole, steadily.
bool only_drifts(const VolumeFlow& flow) {
  return flow.angular_velocity_rad_s.isZero(0) && flow.wave_angular_acceleration_rad_s2.isZero(0) &&
         flow.current_acceleration_m_s2.isZero(0) && flow.wave_acceleration_m_s2.isZero(0);
}

}  // namespace

void CraftParameters::check() const {
  require(std::isfinite(mass_kg) && mass_kg > 0, "vehicle.mass_kg", mass_kg, "must be positive");
  require(centre_of_mass_body_m.allFinite(), "vehicle.centre_of_mass_m", centre_of_mass_body_m.transpose(),
          "must be finite");
  const Eigen::Vector3d principal = eigenvalues(inertia_kg_m2);
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
            quadratic_damping(i, i), "must be at least 0 and at least its cross terms, or drag would add energy");
  }
  require(added_mass.isApprox(added_mass.transpose(), 1e-9) || added_mass.isZero(), "vehicle.added_mass", "asymmetric",
          "must be symmetric");
  require(std::isfinite(coefficients_volume_m3) && coefficients_volume_m3 >= 0, "vehicle.coefficients_volume_m3",
          coefficients_volume_m3, "must be 0 or positive");
  require(munk_share >= 0 && munk_share <= 1, "vehicle.munk_share", munk_share, "must be in [0, 1]");
  require(std::isfinite(crossflow_length_m) && crossflow_length_m >= 0, "vehicle.crossflow_length_m",
          crossflow_length_m, "must be 0 or positive");
  for (const int i : {1, 2, 4, 5}) {
    const double own = quadratic_damping(i, i);
    const bool is_alone =
        quadratic_damping.row(i).cwiseAbs().sum() == own && quadratic_damping.col(i).cwiseAbs().sum() == own;
    require(crossflow_length_m == 0 || is_alone, "vehicle.crossflow_length_m", crossflow_length_m,
            "must be 0 where quadratic_damping has cross terms of sway, heave, pitch or yaw");
  }
  require(buoyancy_share.empty() || (std::isfinite(buoyancy_share_step_m) && buoyancy_share_step_m > 0),
          "vehicle.buoyancy_share_step_m", buoyancy_share_step_m, "must be positive");
  for (const double share : buoyancy_share) {
    require(share >= 0 && share <= 2, "vehicle.buoyancy_share", share, "must be in [0, 2]");
  }
}

CrossflowDrag CraftParameters::crossflow_in_heave() const {
  return {quadratic_damping(2, 2), quadratic_damping(4, 4), crossflow_length_m};
}

CrossflowDrag CraftParameters::crossflow_in_sway() const {
  return {quadratic_damping(1, 1), quadratic_damping(5, 5), crossflow_length_m};
}

double CraftParameters::buoyancy_share_at(double depth_m) const {
  if (buoyancy_share.empty()) return 1;
  const std::size_t last = buoyancy_share.size() - 1;
  const double at = std::clamp(depth_m / buoyancy_share_step_m, 0.0, static_cast<double>(last));
  const auto above = static_cast<std::size_t>(at);
  return std::lerp(buoyancy_share[above], buoyancy_share[std::min(above + 1, last)], at - static_cast<double>(above));
}

Craft::Craft(CraftParameters parameters, BuoyantHull hull)
    : Craft(std::move(parameters), std::make_shared<const BuoyantHull>(std::move(hull))) {}

Craft::Craft(CraftParameters parameters, std::shared_ptr<const BuoyantHull> hull)
    : parameters_(std::move(parameters)), hull_(std::move(hull)) {
  parameters_.check();
  require_inside_box(parameters_.centre_of_mass_body_m, hull_->mesh_body());
  rigid_mass_ = rigid_body_mass(parameters_);
  linear_damping_ = Coefficients(parameters_.linear_damping);
  added_mass_ = Coefficients(parameters_.added_mass);
  coriolis_added_mass_ = Coefficients(with_munk_share(parameters_.added_mass, parameters_.munk_share));
  Matrix6d point_damping = parameters_.quadratic_damping;
  if (parameters_.crossflow_length_m > 0) {
    heave_strips_ = parameters_.crossflow_in_heave();
    sway_strips_ = parameters_.crossflow_in_sway();
    point_damping(1, 1) = point_damping(2, 2) = 0;
    point_damping(4, 4) = std::max(0.0, point_damping(4, 4) - heave_strips_.turning_drag());
    point_damping(5, 5) = std::max(0.0, point_damping(5, 5) - sway_strips_.turning_drag());
  }
  point_damping_ = Coefficients(point_damping);
  momentum_of_ = Coefficients(rigid_mass_);
  inverse_mass_submerged_ = inverse_of_positive(rigid_mass_ + parameters_.added_mass);
  inverse_submerged_ = Coefficients(inverse_mass_submerged_);
  const Modes<6> both = modes(parameters_.added_mass, rigid_mass_);
  mass_modes_ = both.vectors;
  added_mass_of_modes_ = both.values;
}

/// One value for each column of `mass_modes_`.
Vector6d Craft::inverse_mass_of_modes(double submerged) const {
  return (1 + submerged * added_mass_of_modes_.array()).inverse();
}

Matrix6d Craft::inverse_mass_at(double submerged) const {
  if (submerged == 1) return inverse_mass_submerged_;
  return mass_modes_ * inverse_mass_of_modes(submerged).asDiagonal() * mass_modes_.transpose();
}

double Craft::submerged_fraction(const Pose& world_from_body, const WaterField& water, double time_s) const {
  return fraction(hull_->submerged_volume_m3(world_from_body, water, time_s));
}

double Craft::fraction(double wet_volume_m3) const {
  const double whole_m3 = parameters_.coefficients_volume_m3;
  return std::clamp(wet_volume_m3 / (whole_m3 > 0 ? whole_m3 : hull_->solid().volume_m3), 0.0, 1.0);
}

Matrix6d Craft::inverse_mass(const Pose& world_from_body, const WaterField& water, double time_s) const {
  return inverse_mass_at(submerged_fraction(world_from_body, water, time_s));
}

Vector6d Craft::damping_body(const Vector6d& relative_velocity) const {
  Vector6d force = -(linear_damping_ * relative_velocity +
                     point_damping_ * Vector6d(relative_velocity.cwiseAbs().cwiseProduct(relative_velocity)));
  if (parameters_.crossflow_length_m > 0) {
    // At x a turning hull moves across at w - q x in heave, and at v + r x in sway.
    const CrossflowDrag::Load heave = heave_strips_.load(relative_velocity(2), -relative_velocity(4));
    const CrossflowDrag::Load sway = sway_strips_.load(relative_velocity(1), relative_velocity(5));
    force += joined({-0.0, sway.force, heave.force}, {-0.0, -heave.moment, sway.moment});  // -0 changes no number
  }
  return force;
}

/// `terms`: where to write them, without the part of nu'; may be null.
Craft::Load Craft::load(const BodyState& state, const Vector6d& tau_body, const WaterField& water, double time_s,
                        NearbyWater* nearby, Terms* terms) const {
  const Pose& pose = state.world_from_body;
  const Eigen::Matrix3d world_from_body = pose.rotation();
  Buoyancy buoyancy = hull_->buoyancy(pose.position_m, world_from_body, water, time_s, nearby);
  const double submerged = fraction(buoyancy.volume_m3);
  if (!parameters_.buoyancy_share.empty()) {
    const double centre_z_m = pose.position_m.z() + world_from_body.row(2).dot(buoyancy.centre_body_m);
    const double share = parameters_.buoyancy_share_at(-centre_z_m);
    buoyancy.force_body_n *= share;
    buoyancy.moment_body_nm *= share;
  }

  const Eigen::Vector3d weight = -parameters_.mass_kg * water.gravity() * world_from_body.row(2).transpose();
  Vector6d tau = tau_body;
  tau +=
      joined(weight + buoyancy.force_body_n, parameters_.centre_of_mass_body_m.cross(weight) + buoyancy.moment_body_nm);
  tau -= coriolis(momentum_of_ * state.velocity_body, state.velocity_body);
  if (terms != nullptr) {
    terms->weight << weight, parameters_.centre_of_mass_body_m.cross(weight);
    terms->buoyancy << buoyancy.force_body_n, buoyancy.moment_body_nm;
    terms->coriolis = -coriolis(momentum_of_ * state.velocity_body, state.velocity_body);
  }
  if (submerged > 0) {
    const double centre_z_m = pose.position_m.z() + world_from_body.row(2).dot(buoyancy.centre_body_m);
    tau +=
        flow_force_body(state.velocity_body, world_from_body, buoyancy, submerged, water.density_at(centre_z_m), terms);
  }
  return {tau, submerged};
}

Craft::Terms Craft::terms(const BodyState& state, const Vector6d& acceleration_body, const WaterField& water,
                          double time_s, NearbyWater* nearby) const {
  Terms terms;
  const Load now = load(state, Vector6d::Zero(), water, time_s, nearby, &terms);
  terms.added_mass -= now.submerged * (parameters_.added_mass * acceleration_body);
  return terms;
}

Vector6d Craft::acceleration_body(const BodyState& state, const Vector6d& tau_body, const WaterField& water,
                                  double time_s, NearbyWater* nearby) const {
  const auto& [tau, submerged] = load(state, tau_body, water, time_s, nearby, nullptr);
  if (submerged == 1) return inverse_submerged_ * tau;
  return mass_modes_ * inverse_mass_of_modes(submerged).cwiseProduct(mass_modes_.transpose() * tau);
}

/// The forces that depend on the motion of the body through the water, and on the motion of the water.
Vector6d Craft::flow_force_body(const Vector6d& velocity, const Eigen::Matrix3d& world_from_body,
                                const Buoyancy& buoyancy, double submerged, double density_kg_m3, Terms* terms) const {
  const VolumeFlow& flow = buoyancy.flow;
  const Eigen::Vector3d& centre = buoyancy.centre_body_m;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), turn_rate = turn, current_rate = turn, wave_rate = turn;
  if (!only_drifts(flow)) {
    turn = world_from_body.transpose() * flow.angular_velocity_rad_s;
    turn_rate = world_from_body.transpose() * flow.wave_angular_acceleration_rad_s2;
    current_rate = world_from_body.transpose() * flow.current_acceleration_m_s2;
    wave_rate = world_from_body.transpose() * flow.wave_acceleration_m_s2;
  }
  const Eigen::Vector3d drift = world_from_body.transpose() * flow.velocity_m_s - turn.cross(centre);
  const Eigen::Vector3d spin = velocity.tail<3>();
  const Vector6d flow_rate = joined(current_rate + wave_rate - turn_rate.cross(centre) - spin.cross(drift),
                                    turn_rate - spin.cross(turn));  // of the water, at the origin
  const Vector6d relative = velocity - joined(drift, turn);

  Vector6d force = submerged * (damping_body(relative) - coriolis(coriolis_added_mass_ * relative, relative) +
                                added_mass_ * flow_rate);
  const Eigen::Vector3d pressure_force = density_kg_m3 * buoyancy.volume_m3 * current_rate;
  force += joined(pressure_force, buoyancy.centre_body_m.cross(pressure_force));
  if (terms != nullptr) {
    terms->drag = submerged * damping_body(relative);
    terms->added_mass = submerged * (added_mass_ * flow_rate - coriolis(coriolis_added_mass_ * relative, relative));
    terms->buoyancy.head<3>() += pressure_force;
    terms->buoyancy.tail<3>() += buoyancy.centre_body_m.cross(pressure_force);
  }
  return force;
}

double Craft::kinetic_energy_j(const BodyState& state) const {
  const double wet_volume_m3 = hull_->displacement(state.world_from_body).volume_m3,
               submerged = fraction(wet_volume_m3);
  return 0.5 * state.velocity_body.dot((rigid_mass_ + submerged * parameters_.added_mass) * state.velocity_body);
}

}  // namespace uwsim
