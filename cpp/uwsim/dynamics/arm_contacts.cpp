#include <algorithm>
#include <cmath>

#include "uwsim/dynamics/arm.h"
#include "uwsim/dynamics/contact_arm.h"
#include "uwsim/dynamics/resting.h"

// The part of Arm that contacts of its links need.
namespace uwsim {

void Arm::find_motions(const BodyState& from, const BodyState& to, std::span<LinkMotion> motions) {
  for (const bool is_start : {true, false}) {
    const BodyState& base = is_start ? from : to;
    const Joints& joints = is_start ? start_ : next_;
    for (std::size_t k = 0; k < size(); ++k) {
      const ArmLink& link = links()[k];
      const bool on_base = link.parent == ArmLink::kBase;
      const Pose holder = on_base ? Pose{} : link_poses_[link.parent];
      const Vector6d& held = on_base ? base.velocity_body : link_velocities_[link.parent];
      link_poses_[k] = holder * link.parent_from_link_at(joints.positions[k]);  // in the base's frame
      const Eigen::Vector3d turn = held.tail<3>();
      Vector6d& velocity = link_velocities_[k];
      velocity << held.head<3>() + turn.cross(link_poses_[k].position_m - holder.position_m), turn;
      if (link.joint != ArmLink::Joint::kFixed) {
        const Eigen::Vector3d moved = joints.speeds[k] * (link_poses_[k].orientation * link.axis.normalized());
        if (link.joint == ArmLink::Joint::kSlide) velocity.head<3>() += moved;
        if (link.joint == ArmLink::Joint::kHinge) velocity.tail<3>() += moved;
      }
      LinkMotion& motion = motions[k];
      const double linear_m_s = velocity.head<3>().norm(), turn_rad_s = velocity.tail<3>().norm();
      if (is_start) motion = {from.world_from_body * link_poses_[k], linear_m_s, turn_rad_s};
      motion.linear_m_s = std::max(motion.linear_m_s, linear_m_s);
      motion.turn_rad_s = std::max(motion.turn_rad_s, turn_rad_s);
    }
  }
}

Arm::Bounds Arm::bounds(const BodyState& from, const BodyState& to) const {
  const double extent_m = std::max(body_.reach_m(start_.positions), body_.reach_m(next_.positions));
  const double joints_m_s =
      std::max(body_.fastest_m_s(start_.positions, start_.speeds), body_.fastest_m_s(next_.positions, next_.speeds));
  return {extent_m, joints_m_s + std::max(uwsim::fastest_m_s(from.velocity_body, extent_m),
                                          uwsim::fastest_m_s(to.velocity_body, extent_m))};
}

void Arm::describe(const Matrix6d& base_mass, const BodyState& from, const WaterField& water, double time_s,
                   double step_s, ContactArm& contact) {
  body_.place(from, start_.positions, start_.speeds, water, time_s);
  body_.describe(base_mass, step_s, contact);
  for (std::size_t n = 0; n < contact.joints.size(); ++n) {
    const std::size_t k = body_.link_of_joint(n);
    ContactArm::Joint& joint = contact.joints[n];
    joint.law = laws_[k];
    joint.torque = law_torques_[k];
    joint.speed = next_.speeds[k];
    joint.start_speed = start_.speeds[k];
    joint.push_speed = 0;
  }
}

void Arm::push(std::size_t link, const BodyState& from, const Eigen::Vector3d& point_world_m,
               const Eigen::Vector3d& force_world_n) {
  const Eigen::Vector3d origin_m = from.world_from_body.point(body_.push_origin_m(link));
  Vector6d wrench;
  wrench << force_world_n, (point_world_m - origin_m).cross(force_world_n);
  body_.push(link, wrench);
}

void Arm::displace(const ContactArm& contact, double step_s) {
  for (std::size_t n = 0; n < contact.joints.size(); ++n) {
    const std::size_t k = body_.link_of_joint(n);
    double& position = next_.positions[k];
    position = std::clamp(position + step_s * contact.joints[n].push_speed, links()[k].lowest, links()[k].highest);
  }
}

}  // namespace uwsim
