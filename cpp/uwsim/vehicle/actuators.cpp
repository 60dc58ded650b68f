#include "uwsim/vehicle/actuators.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::array<const char*, 6> kAxes = {"surge", "sway", "heave", "roll", "pitch", "yaw"};

template <typename Part>
void require_unique_names(const std::vector<Part>& parts, const char* path) {
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      require(parts[k].name != parts[other].name, path, parts[k].name, "names must be unique");
    }
  }
}

/// Returns the given values in the order of the parts, with 0 for parts that are not named. `limit_of(part)` is the
/// largest magnitude that a part accepts, 0 for a part that accepts no command. Throws InvalidValue for an unknown name
/// or a value beyond the limit.
template <typename Part, typename LimitOf>
std::vector<double> values_by_part(const std::vector<Part>& parts, const Actuators::Named& given, const char* path,
                                   LimitOf limit_of, const char* unit) {
  std::vector<double> values(parts.size(), 0);
  for (const auto& [name, value] : given) {
    const auto part = std::find_if(parts.begin(), parts.end(),
                                   [&](const Part& p) { return p.parameters().name == name && limit_of(p) > 0; });
    if (part == parts.end()) {
      std::string known;
      for (const Part& p : parts) known += limit_of(p) > 0 ? (known.empty() ? "" : ", ") + p.parameters().name : "";
      require(false, path, "'" + name + "'", known.empty() ? "the vehicle has none" : "must be one of " + known);
    }
    const double limit = limit_of(*part);
    if (!(std::abs(value) <= limit)) {
      const std::string bound = printed(limit);
      require(false, path + ("." + name), printed(value) + unit, "must be in [-" + bound + ", " + bound + "]" + unit);
    }
    values[static_cast<std::size_t>(part - parts.begin())] = value;
  }
  return values;
}

/// The number of the propeller in whose slipstream a fin may be.
std::optional<std::size_t> propeller_of(const FinParameters& fin, const std::vector<ThrusterParameters>& thrusters) {
  const auto found = std::find_if(thrusters.begin(), thrusters.end(), [&](const ThrusterParameters& one) {
    return one.name == fin.slipstream_of && !one.is_vertical;
  });
  if (found == thrusters.end()) return std::nullopt;
  return static_cast<std::size_t>(found - thrusters.begin());
}

}  // namespace

void ActuatorsSpec::check() const {
  require(full_wrench_body.allFinite() && full_wrench_body.minCoeff() >= 0, "full_wrench_body",
          full_wrench_body.transpose(), "must not be negative");
  require(thrusters.empty() || full_wrench_body.isZero(0), "full_wrench_body", full_wrench_body.transpose(),
          "must be zero for a vehicle with thrusters");
  require_unique_names(thrusters, "thrusters");
  for (const ThrusterParameters& thruster : thrusters) {
    require(thruster.sheets.voltages_v() == thrusters.front().sheets.voltages_v(), "thrusters." + thruster.name,
            "its sheets", "must be of the same voltages as the other thrusters'");
  }
  require_unique_names(fins, "fins");
  for (const FinParameters& fin : fins) {
    require(fin.slipstream_of.empty() || propeller_of(fin, thrusters), "fins." + fin.name + ".slipstream_of",
            fin.slipstream_of, "must be the name of a thruster that is a propeller");
  }
}

Actuators::Actuators(const ActuatorsSpec& spec) {
  spec.check();
  full_direct_wrench_ = spec.full_wrench_body;
  has_direct_wrench_ = !full_direct_wrench_.isZero(0);
  for (const ThrusterParameters& parameters : spec.thrusters) thrusters_.emplace_back(parameters);
  for (const FinParameters& parameters : spec.fins) {
    fins_.emplace_back(parameters);
    jets_.push_back(propeller_of(parameters, spec.thrusters));
  }

  const auto n = static_cast<Eigen::Index>(thrusters_.size());
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns(6, n);
  Eigen::VectorXd lowest(n), highest(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Thruster& thruster = thrusters_[static_cast<std::size_t>(k)];
    columns.col(k) = thruster.column();
    lowest(k) = thruster.parameters().curve.lowest_n();
    highest(k) = thruster.parameters().curve.highest_n();
    radius_m_ = std::max(radius_m_, thruster.parameters().position_body_m.norm() + thruster.parameters().diameter_m);
  }
  if (!thrusters_.empty()) load_a_.resize(thrusters_.front().parameters().sheets.voltages_v().size());
  allocation_ = Allocation(columns, lowest, highest);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    for (const int side : {0, 1}) {
      const Vector6d unit = (side == 0 ? 1.0 : -1.0) * Vector6d::Unit(axis);
      full_[static_cast<std::size_t>(side)](axis) = full_direct_wrench_(axis) + allocation_.largest_multiple(unit);
    }
  }
  allocate_fins();
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    controllable_[axis] = full_[0](k) > 0 || full_[1](k) > 0 || !fin_angles_rad_.col(k).isZero(0);
  }
}

/// Full effort about roll, pitch or yaw deflects the fins so that, in flow from ahead, they produce a torque about that
/// axis alone, with the least sum of squared deflections and the largest deflection at its limit.
void Actuators::allocate_fins() {
  const auto n = static_cast<Eigen::Index>(fins_.size());
  fin_angles_rad_.setZero(n, 6);
  Eigen::Matrix<double, 6, Eigen::Dynamic> torques(6, n);
  Eigen::VectorXd limit_rad(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Fin& fin = fins_[static_cast<std::size_t>(k)];
    limit_rad(k) = fin.parameters().deflection_max_rad;
    torques.col(k) = limit_rad(k) * fin.column();
    radius_m_ = std::max(radius_m_, fin.parameters().position_body_m.norm() +
                                        std::sqrt(fin.parameters().area_m2 * fin.parameters().aspect_ratio));
  }
  torques.topRows<3>().setZero();
  const std::array<bool, 6> driven = independent_axes(torques);
  std::vector<Eigen::Index> axes;
  for (Eigen::Index axis = 3; axis < 6; ++axis) {
    if (driven[static_cast<std::size_t>(axis)]) axes.push_back(axis);
  }
  if (axes.empty()) return;
  Eigen::MatrixXd chosen(axes.size(), n);
  for (std::size_t k = 0; k < axes.size(); ++k) chosen.row(static_cast<Eigen::Index>(k)) = torques.row(axes[k]);
  const Eigen::MatrixXd shares = chosen.completeOrthogonalDecomposition().pseudoInverse();
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const Eigen::VectorXd share = shares.col(static_cast<Eigen::Index>(k));
    fin_angles_rad_.col(axes[k]) = share.cwiseProduct(limit_rad) / share.cwiseAbs().maxCoeff();
  }
}

Vector6d Actuators::fin_torque_body() const {
  Vector6d torque = Vector6d::Zero();
  for (std::size_t k = 0; k < fins_.size(); ++k) {
    torque += fins_[k].column().cwiseProduct(fin_angles_rad_.row(static_cast<Eigen::Index>(k)).transpose());
  }
  torque.head<3>().setZero();
  return torque;
}

void Actuators::set_effort(const Vector6d& effort) {
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    require(std::abs(effort(axis)) <= 1, std::string("effort.") + kAxes[static_cast<std::size_t>(axis)], effort(axis),
            "must be in [-1, 1]");
  }
  effort_ = effort;
  allocate_effort();
  deflect(effort);
}

void Actuators::allocate_effort() {
  direct_wrench_ = effort_.cwiseProduct(full_direct_wrench_);
  if (thrusters_.empty()) return;
  Vector6d wrench;
  for (Eigen::Index axis = 0; axis < 6; ++axis) wrench(axis) = effort_(axis) * full_[effort_(axis) < 0](axis);
  allocate(wrench);
}

void Actuators::renew_commands() {
  if (!effort_.isZero(0)) allocate_effort();
  direct_wrench_ = direct_wrench_.cwiseMin(full_direct_wrench_).cwiseMax(-full_direct_wrench_);
  for (Fin& fin : fins_) {
    const double limit_rad = fin.parameters().deflection_max_rad;
    fin.set_command(std::clamp(fin.command_rad(), -limit_rad, limit_rad));
  }
}

void Actuators::set_wrench(const Vector6d& wrench_body) {
  require(wrench_body.allFinite(), "wrench_body", wrench_body.transpose(), "must be finite");
  effort_.setZero();
  double scale = 1;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (full_direct_wrench_(axis) > 0 && wrench_body(axis) != 0) {
      scale = std::min(scale, full_direct_wrench_(axis) / std::abs(wrench_body(axis)));
    }
  }
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    direct_wrench_(axis) = full_direct_wrench_(axis) > 0 ? scale * wrench_body(axis) : 0;
  }
  if (!thrusters_.empty()) allocate(wrench_body);
}

void Actuators::allocate(const Vector6d& wrench_body) {
  const Eigen::VectorXd thrusts = allocation_.thrusts_n(wrench_body);
  for (std::size_t k = 0; k < thrusters_.size(); ++k) {
    const double command = thrusters_[k].parameters().curve.command(thrusts(static_cast<Eigen::Index>(k)));
    thrusters_[k].set_command(command);
  }
}

void Actuators::deflect(const Vector6d& effort) {
  const Eigen::VectorXd angles = fin_angles_rad_ * effort;
  double excess = 1;
  for (std::size_t k = 0; k < fins_.size(); ++k) {
    const double limit_rad = fins_[k].parameters().deflection_max_rad;
    if (limit_rad > 0) excess = std::max(excess, std::abs(angles(static_cast<Eigen::Index>(k))) / limit_rad);
  }
  for (std::size_t k = 0; k < fins_.size(); ++k) fins_[k].set_command(angles(static_cast<Eigen::Index>(k)) / excess);
}

void Actuators::set_thrusters(const Named& commands) {
  const std::vector<double> values = values_by_part(
      thrusters_, commands, "thrusters", [](const Thruster&) { return 1.0; }, "");
  for (std::size_t k = 0; k < thrusters_.size(); ++k) thrusters_[k].set_command(values[k]);
  effort_.setZero();
  direct_wrench_.setZero();
}

void Actuators::set_fins(const Named& angles_rad) {
  const std::vector<double> values = values_by_part(
      fins_, angles_rad, "fins", [](const Fin& fin) { return fin.parameters().deflection_max_rad; }, " rad");
  for (std::size_t k = 0; k < fins_.size(); ++k) fins_[k].set_command(values[k]);
}

ElectricalLoad Actuators::load(double step_s) {
  if (load_a_.empty()) return {};
  std::fill(load_a_.begin(), load_a_.end(), 0.0);
  for (Thruster& thruster : thrusters_) thruster.add_current(step_s, load_a_);
  return {thrusters_.front().parameters().sheets.voltages_v(), load_a_};
}

void Actuators::advance(double step_s, const Supply& supply) {
  powered_ = supply.on;
  for (Thruster& thruster : thrusters_) thruster.advance(step_s, supply);
  if (!powered_) return;
  for (Fin& fin : fins_) fin.advance(step_s);
}

void Actuators::exchange_state(StateArchive& archive) {
  archive(effort_);
  archive(direct_wrench_);
  archive(powered_);
  archive.same("thrusters", thrusters_.size());
  for (Thruster& thruster : thrusters_) thruster.exchange_state(archive);
  archive.same("fins", fins_.size());
  for (Fin& fin : fins_) fin.exchange_state(archive);
}

/// Height of the water's surface above the origin; infinite if all actuators are definitely submerged.
double Actuators::surface_above_origin_m(const Pose& world_from_body, const WaterField& water, double time_s) const {
  const Eigen::Vector3d& at = world_from_body.position_m;
  if (at.z() + radius_m_ < -water.wave_bound_m()) return std::numeric_limits<double>::infinity();
  return water.surface_height_at(at.x(), at.y(), time_s) - at.z();
}

Vector6d Actuators::wrench_body(const BodyState& state, const WaterField& water, double time_s,
                                double submerged) const {
  Vector6d tau = powered_ ? (submerged * direct_wrench_).eval() : Vector6d::Zero().eval();
  if (thrusters_.empty() && fins_.empty()) return tau;
  const Pose& pose = state.world_from_body;
  const double surface = surface_above_origin_m(pose, water, time_s);
  const double density = water.density_at(pose.position_m.z());
  Vector6d through_water = state.velocity_body;
  through_water.head<3>() -= pose.orientation.conjugate() * water.flow_at(pose.position_m, time_s).velocity_m_s;
  const Eigen::Vector3d up = pose.rotation().row(2).transpose();  // body frame
  const auto submerged_share = [&](const Thruster& thruster) {
    const ThrusterParameters& p = thruster.parameters();
    return thruster.submerged_fraction(surface - up.dot(p.position_body_m), up.dot(p.axis_body));
  };
  for (const Thruster& thruster : thrusters_) {
    if (thruster.parameters().is_vertical) {
      thruster.add_vertical(up, tau);
      continue;
    }
    const double share = submerged_share(thruster);
    if (share > 0) thruster.add_wrench(through_water, density, share, tau);
  }
  for (std::size_t k = 0; k < fins_.size(); ++k) {
    const FinParameters& p = fins_[k].parameters();
    const double share = fins_[k].submerged_fraction(surface - up.dot(p.position_body_m), up.dot(p.span_body));
    if (share <= 0) continue;
    if (!jets_[k]) {
      fins_[k].add_wrench(through_water, density, share, tau);
      continue;
    }
    const Thruster& propeller = thrusters_[*jets_[k]];
    const double wet = submerged_share(propeller);
    const Slipstream jet = propeller.slipstream(through_water, density, wet, p.position_body_m);
    fins_[k].add_wrench(through_water, density, share, jet, tau);
  }
  return tau;
}

}  // namespace uwsim
