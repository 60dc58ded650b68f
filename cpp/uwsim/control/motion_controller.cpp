#include "uwsim/control/motion_controller.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Eigen::Vector3d;

constexpr double kSlowestClimb_m_s = 0.3;  // below this speed, pitch does not make the vehicle climb
constexpr double kSteepest = 0.35;         // [rad]

/// The vector, shortened to a maximum length if necessary.
template <typename Vector>
Vector limited(const Vector& vector, double longest) {
  const double length = vector.norm();
  return length > longest ? Vector(vector * (longest / length)) : vector;
}

/// The speed of approach to a target at a given distance: gain times distance near the target; farther away, the
/// highest speed from which the vehicle can stop there at constant deceleration, up to a limit.
double approach_speed(double distance, double gain, double deceleration, double fastest) {
  if (gain == 0) return 0;
  const double near = deceleration / (gain * gain);
  const double speed = distance <= near ? gain * distance : std::sqrt(2 * deceleration * (distance - 0.5 * near));
  return std::min(speed, fastest);
}

}  // namespace

void ControlGains::check(double period_s) const {
  require(std::isfinite(period_s) && period_s > 0, "period_s", period_s, "must be positive");
  require(tracking_s >= period_s, "control.tracking_s", tracking_s, "must be at least the control period");
  for (const auto& [name, value] : {std::pair{"filter_s", filter_s},
                                    {"speed_max_m_s", speed_max_m_s},
                                    {"climb_max_m_s", climb_max_m_s},
                                    {"turn_max_rad_s", turn_max_rad_s},
                                    {"acceleration_max_m_s2", acceleration_max_m_s2},
                                    {"turn_acceleration_max_rad_s2", turn_acceleration_max_rad_s2}}) {
    require(std::isfinite(value) && value > 0, std::string("control.") + name, value, "must be positive");
  }
}

MotionController::MotionController(ControlModel model, const ControlGains& gains, double period_s)
    : model_(std::move(model)), gains_(gains), period_s_(period_s) {
  gains.check(period_s);
}

Vector6d MotionController::reach(const MotionEstimate& estimate, const MotionTarget& target) {
  Vector3d towards = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double left_m = target.position_world_m[axis] - estimate.position_world_m[axis];
    if (!std::isnan(left_m)) towards[axis] = left_m;
  }
  // Surge and sway share one gain: the mean of their gains, weighted by the components of the direction of travel.
  const Eigen::Vector2d level = towards.head<2>();
  const double distance_m = level.norm(), yaw_rad = estimate.yaw_rad();
  const double ahead =
      distance_m > 0 ? (std::cos(yaw_rad) * level.x() + std::sin(yaw_rad) * level.y()) / distance_m : 1;
  const double gain = ahead * ahead * gains_.loops[0].position_1_s + (1 - ahead * ahead) * gains_.loops[1].position_1_s;
  const double speed = approach_speed(distance_m, gain, gains_.acceleration_max_m_s2, gains_.speed_max_m_s);
  const double climb = approach_speed(std::abs(towards.z()), gains_.loops[2].position_1_s, gains_.acceleration_max_m_s2,
                                      gains_.climb_max_m_s);
  Vector3d approach = Vector3d::Zero();
  if (distance_m > 0) approach.head<2>() = level * (speed / distance_m);
  approach.z() = std::copysign(climb, towards.z());
  const Vector3d velocity = target.velocity_world_m_s + approach;
  MotionTarget attitude = target;
  const bool climbs_by_pitch = !model_.driven()[2] && model_.driven()[4];
  if (climbs_by_pitch) {
    const double ahead_m_s = std::max(estimate.velocity_body[0], kSlowestClimb_m_s);
    attitude.pitch_rad -= std::clamp(std::asin(std::clamp(velocity.z() / ahead_m_s, -1.0, 1.0)), -kSteepest, kSteepest);
  }
  return track(estimate, velocity, turn_towards(estimate, attitude), target.across_first);
}

Vector6d MotionController::hold_velocity(const MotionEstimate& estimate, const Vector6d& velocity_body) {
  Vector3d turn = turn_towards(estimate, {.heading_rad = estimate.yaw_rad()});
  if (velocity_body[3] != 0) turn.x() = velocity_body[3];
  if (velocity_body[4] != 0) turn.y() = velocity_body[4];
  turn.z() = velocity_body[5];
  return track(estimate, estimate.world_from_body * velocity_body.head<3>(), turn, false);
}

/// The angular velocity, in body axes, for turning towards an attitude.
Vector3d MotionController::turn_towards(const MotionEstimate& estimate, const MotionTarget& target) const {
  const Eigen::Matrix3d wanted =
      (Eigen::AngleAxisd(target.heading_rad, Vector3d::UnitZ()) *
       Eigen::AngleAxisd(target.pitch_rad, Vector3d::UnitY()) * Eigen::AngleAxisd(target.roll_rad, Vector3d::UnitX()))
          .toRotationMatrix();
  const Eigen::AngleAxisd left(Eigen::Matrix3d(estimate.world_from_body.transpose() * wanted));
  double gain = 0;  // mean over the axes about which the vehicle turns
  for (int axis = 0; axis < 3; ++axis) {
    gain += left.axis()[axis] * left.axis()[axis] * gains_.loops[static_cast<std::size_t>(3 + axis)].position_1_s;
  }
  return left.axis() * approach_speed(left.angle(), gain, gains_.turn_acceleration_max_rad_s2, gains_.turn_max_rad_s);
}

Vector6d MotionController::track(const MotionEstimate& estimate, const Vector3d& velocity_world_m_s,
                                 const Vector3d& turn_body_rad_s, bool across_first) {
  const Eigen::Matrix3d& world_from_body = estimate.world_from_body;
  const Vector6d& measured = estimate.velocity_body;
  if (!memory.begun) {
    memory.velocity_world_m_s = world_from_body * measured.head<3>();
    memory.turn_body_rad_s = measured.tail<3>();
    memory.measured_body = measured;
    memory.begun = true;
  }
  const Vector3d gain =
      limited(Vector3d(velocity_world_m_s - memory.velocity_world_m_s), gains_.acceleration_max_m_s2 * period_s_);
  const Vector3d spin =
      limited(Vector3d(turn_body_rad_s - memory.turn_body_rad_s), gains_.turn_acceleration_max_rad_s2 * period_s_);
  // The error is the one at the start of the period; the feed-forward leads to the reference at its end.
  Vector6d error, reference, acceleration;
  error << world_from_body.transpose() * memory.velocity_world_m_s, memory.turn_body_rad_s;
  error -= measured;
  memory.velocity_world_m_s += gain;
  memory.turn_body_rad_s += spin;
  reference << world_from_body.transpose() * memory.velocity_world_m_s, memory.turn_body_rad_s;
  acceleration << world_from_body.transpose() * gain / period_s_, spin / period_s_;
  acceleration.head<3>() -= measured.tail<3>().cross(reference.head<3>());  // because body axes rotate

  std::array<Pid, 6> loops;
  std::array<PidGains, 6> gains;
  Vector6d integral, wish;
  integral << world_from_body.transpose() * memory.integral_world, memory.integral_body;
  for (int axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const LoopGains& loop = gains_.loops[k];
    gains[k] = {loop.velocity_1_s, loop.integral_1_s2, loop.acceleration_1, gains_.filter_s, gains_.tracking_s};
    loops[k] = Pid(integral[axis], memory.derivative_body[axis], memory.measured_body[axis]);
    wish[axis] = loops[k].output(error[axis], measured[axis], gains[k], period_s_);
  }
  acceleration += wish;
  const Vector6d wanted = model_.wrench_body(world_from_body, reference, acceleration);
  const Vector6d given = model_.reachable(wanted, measured[0], across_first);
  const double wanted_n = model_.driven_part(wanted).head<3>().norm();
  force_share_ = wanted_n > 0 ? given.head<3>().norm() / wanted_n : 1;
  const Vector6d applied = wish + model_.change_body(given - model_.driven_part(wanted));
  for (int axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    loops[k].settle(applied[axis], gains[k], period_s_);
    integral[axis] = model_.driven()[k] ? loops[k].integral : 0;
    memory.derivative_body[axis] = loops[k].derivative;
  }
  memory.measured_body = measured;
  memory.integral_world = world_from_body * integral.head<3>();
  memory.integral_body = integral.tail<3>();
  return model_.effort(given, measured[0]);
}

}  // namespace uwsim
