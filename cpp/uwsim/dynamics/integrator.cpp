#include "uwsim/dynamics/integrator.h"

namespace uwsim {
namespace {

/// The quaternion without a real part, made in registers, as `joined` is.
Eigen::Quaterniond pure(const Eigen::Vector3d& v) {
  const Vector6d both = joined(v, Eigen::Vector3d::Zero());
  Eigen::Quaterniond quaternion;
  quaternion.coeffs() = both.head<4>();
  return quaternion;
}

/// Computes the rates of a stage from its state and time.
void evaluate(Stage& stage, const Craft& craft, const Loads& loads, const WaterField& water, const Vector6d* extra,
              NearbyWater* nearby) {
  Vector6d tau_body = loads.at(stage.state.world_from_body.orientation);
  if (extra != nullptr) tau_body += *extra;
  stage.rate = rate_at(stage.state, craft.acceleration_body(stage.state, tau_body, water, stage.time_s, nearby));
}

/// `nearby`: where the water that the first stage finds is kept for the others; may be null.
std::array<Stage, 4> stages_in(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                               double time_s, double step_s, const std::array<Vector6d, 4>* extra_body,
                               NearbyWater* nearby) {
  std::array<Stage, 4> k;
  k[0].state = state;
  k[0].time_s = time_s;
  for (std::size_t n = 0; n < k.size(); ++n) {
    if (n > 0) {
      const double elapsed_s = n < 3 ? step_s / 2 : step_s;
      k[n].state = moved_at(state, k[n - 1].rate, elapsed_s);
      k[n].time_s = time_s + elapsed_s;
    }
    evaluate(k[n], craft, loads, water, extra_body != nullptr ? &(*extra_body)[n] : nullptr, nearby);
  }
  return k;
}

}  // namespace

Vector6d Loads::at(const Eigen::Quaterniond& world_from_body) const {
  if (world.isZero(0)) return body + Vector6d::Zero();  // a zero of the sum has the sign +, as below
  return body + in_body_axes(world, world_from_body);
}

Rate rate_at(const BodyState& state, const Vector6d& acceleration_body) {
  const Eigen::Quaterniond& q = state.world_from_body.orientation;
  const Eigen::Quaterniond spin = q * pure(state.angular_body_rad_s());
  return {q * state.linear_body_m_s(), 0.5 * spin.coeffs(), acceleration_body};
}

BodyState moved_at(const BodyState& state, const Rate& rate, double time_s) {
  BodyState next;
  next.world_from_body.position_m = state.world_from_body.position_m + time_s * rate.position;
  next.world_from_body.orientation.coeffs() =
      (state.world_from_body.orientation.coeffs() + time_s * rate.quaternion).normalized();
  next.velocity_body = state.velocity_body + time_s * rate.velocity;
  return next;
}

Vector6d in_body_axes(const Vector6d& wrench_world, const Eigen::Quaterniond& world_from_body) {
  return joined(world_from_body.conjugate() * wrench_world.head<3>(),
                world_from_body.conjugate() * wrench_world.tail<3>());
}

Pose displaced(const Pose& pose, const Vector6d& velocity_body, double duration_s) {
  const Eigen::Vector3d rotation = duration_s * velocity_body.tail<3>();
  const double angle = rotation.norm();
  Pose moved;
  moved.position_m = pose.position_m + duration_s * (pose.orientation * velocity_body.head<3>());
  moved.orientation =
      angle == 0 ? pose.orientation
                 : (pose.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle))).normalized();
  return moved;
}

std::array<Stage, 4> stages(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                            double time_s, double step_s, const std::array<Vector6d, 4>* extra_body) {
  // Arms and hull waves, which the extra wrenches are of, step their bodies without keeping any water.
  if (extra_body != nullptr || !is_kept_in_a_step(water))
    return stages_in(craft, state, loads, water, time_s, step_s, extra_body, nullptr);
  NearbyWater nearby;
  return stages_in(craft, state, loads, water, time_s, step_s, extra_body, &nearby);
}

BodyState advance(const Craft& craft, const BodyState& state, const Loads& loads, const WaterField& water,
                  double time_s, double step_s) {
  const auto [one, two, three, four] = stages(craft, state, loads, water, time_s, step_s);
  const Rate &k1 = one.rate, &k2 = two.rate, &k3 = three.rate, &k4 = four.rate;
  const Rate mean = {(k1.position + 2 * k2.position + 2 * k3.position + k4.position) / 6,
                     (k1.quaternion + 2 * k2.quaternion + 2 * k3.quaternion + k4.quaternion) / 6,
                     (k1.velocity + 2 * k2.velocity + 2 * k3.velocity + k4.velocity) / 6};
  return moved_at(state, mean, step_s);
}

}  // namespace uwsim
