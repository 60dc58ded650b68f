#include "uwsim/control/control_model.h"
#include "uwsim/core/symmetric.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace uwsim {
namespace {

constexpr double kDeep_m = -1e3;  // deep enough to keep the whole hull away from the surface
constexpr double kSlowest_m_s = 0.3;
constexpr int kHalvings = 8;  // resolves the requested force along the vehicle to 0.4 %

Pose deep(const Eigen::Matrix3d& world_from_body) { return {{0, 0, kDeep_m}, Eigen::Quaterniond(world_from_body)}; }

}  // namespace

ControlModel::ControlModel(std::shared_ptr<const Craft> craft, const ActuatorsSpec& actuators, double density_kg_m3,
                           double gravity_m_s2)
    : craft_(std::move(craft)), actuators_(actuators) {
  water_.density_kg_m3 = density_kg_m3;
  water_.gravity_m_s2 = gravity_m_s2;
  inverse_mass_ = craft_->inverse_mass(deep(Eigen::Matrix3d::Identity()), water_, 0);
  mass_ = inverse_of_positive(inverse_mass_);
  const auto& [ahead, astern] = actuators_.full_wrench_body();
  fin_torque_ = actuators_.fin_torque_body();
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (ahead(axis) > 0 && astern(axis) > 0) fin_torque_(axis) = 0;
    driven_[static_cast<std::size_t>(axis)] = fin_torque_(axis) != 0 || (ahead(axis) > 0 && astern(axis) > 0);
  }
}

/// The torque at full effort. At very low speeds, where fins hardly turn the vehicle, the torque at a small minimum
/// speed is used.
Vector6d ControlModel::fin_limit(double surge_m_s) const {
  const double speed = std::max(surge_m_s, kSlowest_m_s);
  return 0.5 * water_.density_kg_m3 * speed * speed * fin_torque_.cwiseAbs();
}

Vector6d ControlModel::wrench_body(const Eigen::Matrix3d& world_from_body, const Vector6d& velocity,
                                   const Vector6d& acceleration) const {
  const BodyState state{deep(world_from_body), velocity};
  return mass_ * (acceleration - craft_->acceleration_body(state, Vector6d::Zero(), water_, 0));
}

Vector6d ControlModel::driven_part(const Vector6d& wrench_body) const {
  Vector6d part = Vector6d::Zero();
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (driven_[static_cast<std::size_t>(axis)]) part(axis) = wrench_body(axis);
  }
  return part;
}

/// Bisection finds the largest force along the vehicle that is compatible with the other components; it works because
/// the set of reachable wrenches is convex.
Vector6d ControlModel::by_thrusters(const Vector6d& wrench_body, bool across_first) const {
  const Allocation& allocation = actuators_.allocation();
  const Vector6d all = allocation.reachable(wrench_body);
  if (!across_first || all.head<3>() == driven_part(wrench_body).head<3>()) return all;
  Vector6d rest = wrench_body;
  rest[0] = 0;
  Vector6d given = allocation.reachable(rest);
  double lowest = 0, step = 1;
  for (int k = 0; k < kHalvings; ++k) {
    step *= 0.5;
    Vector6d more = given;
    more[0] = (lowest + step) * wrench_body[0];
    if (allocation.largest_multiple(more) >= 1) lowest += step;
  }
  given[0] = lowest * wrench_body[0];
  return given;
}

Vector6d ControlModel::reachable(const Vector6d& wrench_body, double surge_m_s, bool across_first) const {
  const auto& [ahead, astern] = actuators_.full_wrench_body();
  const Vector6d fins = fin_limit(surge_m_s);
  const Vector6d by_fins = wrench_body.cwiseMax(-fins).cwiseMin(fins);
  if (!actuators_.has_direct_wrench()) return by_thrusters(wrench_body, across_first) + by_fins;
  return wrench_body.cwiseMax(-astern).cwiseMin(ahead) + by_fins;
}

Vector6d ControlModel::effort(const Vector6d& wrench_body, double surge_m_s) const {
  const Vector6d fins = fin_limit(surge_m_s);
  Vector6d effort = driven_part(wrench_body);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (effort(axis) == 0) continue;
    const double full = fin_torque_(axis) == 0 ? actuators_.full_wrench_body()[effort(axis) < 0](axis)
                                               : std::copysign(fins(axis), fin_torque_(axis));
    effort(axis) = std::clamp(wrench_body(axis) / full, -1.0, 1.0);
  }
  return effort;
}

}  // namespace uwsim
