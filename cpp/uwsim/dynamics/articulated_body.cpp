#include "uwsim/dynamics/articulated_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// M_RB at the link's origin (Fossen 3.44).
Matrix6d rigid_mass_of(const ArmLink& link) {
  const Eigen::Matrix3d s = cross_matrix_of(link.centre_of_mass_m);
  Matrix6d m;
  m << link.mass_kg * Eigen::Matrix3d::Identity(), -link.mass_kg * s, link.mass_kg * s,
      link.inertia_kg_m2 - link.mass_kg * s * s;
  return m;
}

void add_force_at(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_n, Vector6d& wrench) {
  wrench.head<3>() += force_n;
  wrench.tail<3>() += point_m.cross(force_n);
}

double submerged_of(const ArmLink& link, const Eigen::Vector3d& centre_m, const WaterField& water, double time_s) {
  if (link.volume_m3 == 0) return centre_m.z() < 0 ? 1 : 0;
  const double diameter_m = std::cbrt(6 * link.volume_m3 / std::numbers::pi);
  if (centre_m.z() < -diameter_m - water.wave_bound_m()) return 1;
  const double surface_m = water.surface_height_at(centre_m.x(), centre_m.y(), time_s);
  return std::clamp(0.5 + (surface_m - centre_m.z()) / diameter_m, 0.0, 1.0);
}

}  // namespace

ArticulatedBody::ArticulatedBody(std::vector<ArmLink> links) : links_(std::move(links)), work_(links_.size()) {
  check_links(links_);
  for (const ArmLink& link : links_) {
    rigid_mass_.push_back(rigid_mass_of(link));
    Vector6d axis = Vector6d::Zero();
    if (link.joint == ArmLink::Joint::kHinge) axis.tail<3>() = link.axis.normalized();
    if (link.joint == ArmLink::Joint::kSlide) axis.head<3>() = link.axis.normalized();
    axes_.push_back(axis);
  }
}

void ArticulatedBody::place(const BodyState& base, std::span<const double> positions, std::span<const double> speeds,
                            const WaterField& water, double time_s) {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const ArmLink& link = links_[k];
    Work& at = work_[k];
    const bool on_base = link.parent == ArmLink::kBase;
    Pose parent_from_link = link.parent_from_link;
    if (link.joint == ArmLink::Joint::kHinge) {
      parent_from_link.orientation =
          parent_from_link.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(positions[k], axes_[k].tail<3>()));
    } else if (link.joint == ArmLink::Joint::kSlide) {
      parent_from_link.position_m += parent_from_link.orientation * (positions[k] * axes_[k].head<3>());
    }
    at.parent = {parent_from_link.rotation(), parent_from_link.position_m};
    at.world_from_link = (on_base ? base.world_from_body : work_[link.parent].world_from_link) * parent_from_link;
    at.speed = link.joint == ArmLink::Joint::kFixed ? 0 : speeds[k];
    const Vector6d moved = at.speed * axes_[k];
    at.velocity = at.parent.motion_to_child(on_base ? base.velocity_body : work_[link.parent].velocity) + moved;
    at.bias_velocity = cross_motion(at.velocity, moved);
    set_loads(k, water, time_s);
  }
}

/// Mass and bias of a link alone.
void ArticulatedBody::set_loads(std::size_t k, const WaterField& water, double time_s) {
  const ArmLink& link = links_[k];
  Work& at = work_[k];
  const Eigen::Matrix3d world_from_link = at.world_from_link.rotation();
  const Eigen::Vector3d& centre = link.centre_of_buoyancy_m;
  const Eigen::Vector3d up = world_from_link.row(2).transpose();
  const Eigen::Vector3d centre_world = at.world_from_link.position_m + world_from_link * centre;
  at.mass = rigid_mass_[k];
  at.weight_n = link.mass_kg * water.gravity();
  at.lift_n = 0;
  at.own_bias = cross_force(at.velocity, rigid_mass_[k] * at.velocity);
  Vector6d load = Vector6d::Zero();
  add_force_at(link.centre_of_mass_m, -at.weight_n * up, load);
  const double submerged = submerged_of(link, centre_world, water, time_s);
  if (submerged > 0) {
    const double displaced_kg = submerged * water.density_at(centre_world.z()) * link.volume_m3;
    const WaterFlow flow = water.flow_at(centre_world, time_s);
    const Eigen::Vector3d flow_rate =
        world_from_link.transpose() * (flow.wave_acceleration_m_s2 + flow.current_acceleration_m_s2);
    Vector6d moving = Vector6d::Zero(), moving_rate = Vector6d::Zero();
    moving.head<3>() = world_from_link.transpose() * flow.velocity_m_s;
    moving_rate.head<3>() = flow_rate - at.velocity.tail<3>().cross(moving.head<3>());
    const Vector6d relative = at.velocity - moving;
    at.lift_n = displaced_kg * water.gravity();
    add_force_at(centre, at.lift_n * up + displaced_kg * flow_rate, load);
    Vector6d at_centre = relative;
    at_centre.head<3>() += relative.tail<3>().cross(centre);
    const Vector6d drag =
        -submerged *
        (link.linear_drag + link.quadratic_drag.cwiseProduct(at_centre.cwiseAbs())).cwiseProduct(at_centre);
    add_force_at(centre, drag.head<3>(), load);
    load.tail<3>() += drag.tail<3>();
    at.mass += submerged * link.added_mass;
    at.own_bias += submerged * (cross_force(relative, link.added_mass * relative) - link.added_mass * moving_rate);
  }
  at.own_bias -= load;
}

ArticulatedBody::Reaction ArticulatedBody::fold(std::span<const JointDrive> drives) {
  for (Work& at : work_) {
    at.inertia = at.mass;
    at.bias = at.own_bias;
  }
  Reaction reaction;
  for (std::size_t k = links_.size(); k-- > 0;) {
    const ArmLink& link = links_[k];
    Work& at = work_[k];
    at.is_given = drives[k].has_acceleration || link.joint == ArmLink::Joint::kFixed;
    at.acceleration = link.joint == ArmLink::Joint::kFixed ? 0 : drives[k].value;
    Matrix6d inertia = at.inertia;
    Vector6d bias;
    if (at.is_given) {
      bias = at.bias + at.inertia * (at.bias_velocity + at.acceleration * axes_[k]);
    } else {
      at.torque = drives[k].value;
      at.reach = at.inertia * axes_[k];
      at.scale = axes_[k].dot(at.reach) + link.reflected_inertia();
      at.force = at.torque - link.viscous_friction * at.speed - axes_[k].dot(at.bias);
      inertia -= at.reach * (at.reach / at.scale).transpose();
      bias = at.bias + inertia * at.bias_velocity + at.reach * (at.force / at.scale);
    }
    const bool on_base = link.parent == ArmLink::kBase;
    (on_base ? reaction.inertia : work_[link.parent].inertia) += at.parent.inertia_to_parent(inertia);
    (on_base ? reaction.bias : work_[link.parent].bias) += at.parent.force_to_parent(bias);
  }
  return reaction;
}

void ArticulatedBody::unfold(const Vector6d& base_acceleration) {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const ArmLink& link = links_[k];
    Work& at = work_[k];
    const Vector6d& parent = link.parent == ArmLink::kBase ? base_acceleration : work_[link.parent].rate;
    at.rate = at.parent.motion_to_child(parent) + at.bias_velocity;
    if (!at.is_given) at.acceleration = (at.force - at.reach.dot(at.rate)) / at.scale;
    at.rate += at.acceleration * axes_[k];
    if (at.is_given) {
      at.torque = axes_[k].dot(at.inertia * at.rate + at.bias) + link.reflected_inertia() * at.acceleration +
                  link.viscous_friction * at.speed;
    }
  }
}

Vector6d ArticulatedBody::momentum_base() const {
  Vector6d sum = Vector6d::Zero();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    Vector6d momentum = work_[k].mass * work_[k].velocity;
    for (std::size_t at = k; at != ArmLink::kBase; at = links_[at].parent)
      momentum = work_[at].parent.force_to_parent(momentum);
    sum += momentum;
  }
  return sum;
}

double ArticulatedBody::kinetic_energy_j() const {
  double sum = 0;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Work& at = work_[k];
    sum += 0.5 * at.velocity.dot(at.mass * at.velocity) + 0.5 * links_[k].reflected_inertia() * at.speed * at.speed;
  }
  return sum;
}

double ArticulatedBody::potential_energy_j() const {
  double sum = 0;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Work& at = work_[k];
    sum += at.weight_n * at.world_from_link.point(links_[k].centre_of_mass_m).z() -
           at.lift_n * at.world_from_link.point(links_[k].centre_of_buoyancy_m).z();
  }
  return sum;
}

}  // namespace uwsim
