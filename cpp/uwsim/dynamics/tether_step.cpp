#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"
#include "uwsim/dynamics/point_jacobian.h"
#include "uwsim/dynamics/tether.h"

// The part of Tether that finds the nodes' next positions.
namespace uwsim {
namespace {

constexpr int kTurns = 4;              // solutions of a step
constexpr double kTurnsLittle = 0.05;  // rad
constexpr double kUnseen_m_s = 0.5;    // contacts are searched as far as forces may move a node in a step
constexpr double kLeast = 1e-12;       // m and m/s, below which a direction is arbitrary

}  // namespace

/// Returns the parts of `v` along and across a unit vector, times factors.
Eigen::Vector3d Tether::scaled(const Eigen::Vector3d& v, const Eigen::Vector3d& unit, double along, double across) {
  return across * v + (along - across) * unit.dot(v) * unit;
}

void Tether::step(std::span<MovedBody> bodies, const WaterField& water, double time_s, double step_s) {
  const std::array at = {&spec_.first, &spec_.second};
  for (std::size_t k = 0; k < 2; ++k) {
    ends_[k] = end_of(*at[k], bodies, water, time_s, step_s);
    turn_back(ends_[k], end_forces_[k], step_s);
  }
  drum_ = drum(step_s);
  freeze(water, time_s, step_s);
  freeze_contacts(bodies, step_s, kUnseen_m_s * step_s, step_s);
  yield_hulls(bodies, water, time_s, step_s);
  for (int turn = 0; turn < kTurns; ++turn) {
    find_next(step_s);
    bool is_turned = true;
    for (std::size_t k = 0; k < 2; ++k) is_turned = !turn_back(ends_[k], end_forces_[k], step_s) && is_turned;
    if (is_turned) break;
  }
  push_hulls(bodies);
  for (std::size_t k = 0; k < 2; ++k) {
    if (ends_[k].is_fixed) continue;
    MovedBody& body = bodies[at[k]->body];
    const Pose& pose = body.state.world_from_body;
    const Eigen::Vector3d& force = end_forces_[k];
    body.tether_world.head<3>() += force;
    body.tether_world.tail<3>() += pose.direction(at[k]->point_m).cross(force);
    if (ends_[k].turns_back) body.tether_world.tail<3>() += pose.direction(ends_[k].torque_body(force, step_s));
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (next_[i].cwiseAbs().maxCoeff() < kDiverged) continue;  // false for NaN
    require(false, spec_.name, next_[i].transpose(), "the motion of its node " + std::to_string(i) + " diverged");
  }
}

Tether::End Tether::end_of(const TetherEnd& end, std::span<MovedBody> bodies, const WaterField& water, double time_s,
                           double step_s) const {
  End now;
  now.next = end_point(end, bodies);
  if (end.body == TetherEnd::kNoBody || bodies[end.body].held) return now;
  MovedBody& body = bodies[end.body];
  if (body.spec.path) {
    now.next = body.spec.path->at(time_s + step_s).world_from_body.point(end.point_m);
    return now;
  }
  if (body.arm) body.arm->begin();
  const Pose& pose = body.state.world_from_body;
  const BodyState free = body.advanced(body.state, body.loads(Vector6d::Zero(), step_s), water, time_s, step_s);
  now.is_fixed = false;
  now.next = now.free_next = free.world_from_body.point(end.point_m);
  now.turn_body = now.free_turn_body = free.angular_body_rad_s();
  now.jacobian = point_jacobian(pose, end.point_m);
  now.inverse_mass = body.inverse_mass(pose, water, time_s);
  now.mass = (now.jacobian * now.inverse_mass * now.jacobian.transpose()).inverse();
  now.lever_body_m = end.point_m;
  now.body_from_world = pose.rotation().transpose();
  return now;
}

/// Takes the torque of a force on a body as it will be once the body has turned in the step: -H times the turn, where H
/// is the part of (r . F) 1 - (r F^T + F r^T) / 2 that turns back. Otherwise a body that swings at a taut tether gains
/// energy: a share of (w dt)^2 / 2 of it in each step, where w is its angular frequency. Returns false and changes
/// nothing where the force would turn the body by little more than the one at hand.
bool Tether::turn_back(End& end, const Eigen::Vector3d& force_n, double step_s) {
  if (end.is_fixed) return false;
  const Eigen::Vector3d force_body = end.body_from_world * force_n;
  const Eigen::Matrix3d inverse_inertia = end.inverse_mass.bottomRightCorner<3, 3>();
  const double changes = (force_body - end.force_body_n).norm() * end.lever_body_m.norm() * inverse_inertia.trace();
  if (step_s * step_s * changes <= (end.turns_back ? kTurnsLittle : 0)) return false;
  Eigen::Matrix3d turning =
      -0.5 * (end.lever_body_m * force_body.transpose() + force_body * end.lever_body_m.transpose());
  turning.diagonal().array() += end.lever_body_m.dot(force_body);
  const Modes<3> parts = principal_axes(turning);
  end.stiffness = parts.vectors * parts.values.cwiseMax(0).asDiagonal() * parts.vectors.transpose();
  end.force_body_n = force_body;
  end.turns_back = true;
  // (M + dt^2 H)^-1 = M^-1 - B K B^T, where B are the last columns of M^-1.
  const Eigen::Matrix<double, 6, 3> columns = end.inverse_mass.rightCols<3>();
  const Eigen::Matrix3d soft = step_s * step_s * end.stiffness;
  const Eigen::Matrix3d held = soft * (Eigen::Matrix3d::Identity() + inverse_inertia * soft).inverse();
  const Eigen::Matrix<double, 3, 3> turned = end.jacobian * columns;
  const Eigen::Matrix3d mobility =
      end.jacobian * end.inverse_mass * end.jacobian.transpose() - turned * held * turned.transpose();
  end.mass = mobility.inverse();
  end.next = end.free_next - step_s * turned * (held * end.free_turn_body);
  end.turn_body = end.free_turn_body - inverse_inertia * (held * end.free_turn_body);
  end.turn_per_n = (turned - turned * held * inverse_inertia).transpose() * step_s;
  return true;
}

void Tether::freeze(const WaterField& water, double time_s, double step_s) {
  const std::size_t last = elements();
  double passed = 0;
  for (std::size_t i = 0; i <= last; ++i) {
    line_.points[i] = nodes_[i].position;
    line_.along_m[i] = passed;
    if (i < last) passed += rest_m(i);
  }
  for (std::size_t i = 0; i <= last; ++i) {
    Frozen& f = frozen_[i];
    const std::size_t before = i == 0 || broken_ == i - 1 ? i : i - 1, after = i == last || broken_ == i ? i : i + 1;
    const Eigen::Vector3d along = line_.points[after] - line_.points[before];
    const double length = along.norm();
    f.tangent = length > kLeast ? Eigen::Vector3d(along / length) : Eigen::Vector3d::UnitX();
    line_.half_heights_m[i] = 0.5 * (spec_.diameter_m + std::abs(f.tangent.z()) * span_m(i));
  }
  const std::size_t count = nodes_.size();
  flow_.find({{line_.points.data(), count}, {line_.along_m.data(), count}, {line_.half_heights_m.data(), count}}, water,
             time_s + step_s);
  for (std::size_t i = 0; i <= last; ++i) {
    Frozen& f = frozen_[i];
    const Node& node = nodes_[i];
    f.target = node.position + step_s * node.velocity;
    freeze_water(i, water, step_s);
    freeze_bed(i);
    f.stretch_m = i == last ? 0 : std::max(0.0, (nodes_[i + 1].position - node.position).norm() - rest_m(i));
  }
  find_stiffness(1, step_s);
}

/// Mass, weight and the water's forces. A node is wet in proportion to what of its height lies below the surface.
void Tether::freeze_water(std::size_t i, const WaterField& water, double step_s) {
  Frozen& f = frozen_[i];
  const double length = span_m(i), mass = mass_kg(i), wet = flow_.wet(i);
  f.force = {0, 0, -mass * water.gravity()};
  f.flow.setZero();
  f.normal_mass = f.tangential_mass = mass;
  f.normal_drag = f.tangential_drag = 0;
  const double per_s2 = 1 / (step_s * step_s);
  f.inertia = per_s2 * mass * Eigen::Matrix3d::Identity();
  if (wet == 0) return;
  const double density = wet * water.density_at(nodes_[i].position.z());
  const double displaced = density * std::numbers::pi / 4 * spec_.diameter_m * spec_.diameter_m * length;
  const WaterFlow& flow = flow_.at(i);
  const Eigen::Vector3d rate = flow.wave_acceleration_m_s2 + flow.current_acceleration_m_s2;
  f.flow = flow.velocity_m_s;
  f.force.z() += displaced * water.gravity();
  f.force += displaced * scaled(rate, f.tangent, 1 + spec_.tangential_added_mass, 1 + spec_.normal_added_mass);
  f.normal_mass += displaced * spec_.normal_added_mass;
  f.tangential_mass += displaced * spec_.tangential_added_mass;
  f.inertia.diagonal().setConstant(per_s2 * f.normal_mass);
  f.inertia += per_s2 * (f.tangential_mass - f.normal_mass) * f.tangent * f.tangent.transpose();
  const double area = 0.5 * density * spec_.diameter_m * length;
  f.normal_drag = area * spec_.normal_drag;
  f.tangential_drag = area * std::numbers::pi * spec_.tangential_drag;
}

Tether::Drum Tether::drum(double step_s) const {
  Drum still{first_m_, first_m_, spec_.strongest_n};
  if (winch_.mode == WinchCommand::Mode::kHold || broken_ == 0) return still;
  const double most = first_m_ + std::max(0.0, spec_.most_m() - length_m());
  const double least = first_m_ - std::max(0.0, length_m() - spec_.least_m());
  const bool by_rate = winch_.mode == WinchCommand::Mode::kRate;
  const double rate = by_rate ? winch_.value : spec_.fastest_m_s;
  const double out = std::min(most, first_m_ + std::abs(rate) * step_s);
  const double in = std::max(least, first_m_ - std::abs(rate) * step_s);
  if (!by_rate) return {in, out, winch_.value};
  return winch_.value >= 0 ? Drum{out, out, spec_.strongest_n} : Drum{in, first_m_, spec_.strongest_n};
}

}  // namespace uwsim
