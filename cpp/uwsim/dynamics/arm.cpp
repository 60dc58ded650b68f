#include "uwsim/dynamics/arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kFastest = 1e6;     // per s: only joints that diverge get this far
constexpr double kLeastDecay = 2.5;  // of Runge-Kutta: at 2.79, friction in a step would add energy
constexpr int kIterations = 100;     // of Murty's method, which seldom takes more than three

/// The inertia that a joint moves at least, about its axis.
double own_inertia(const ArmLink& link) {
  const Eigen::Vector3d axis = link.axis.normalized();
  const double turning =
      axis.dot(link.inertia_kg_m2 * axis) + link.mass_kg * axis.cross(link.centre_of_mass_m).squaredNorm();
  return (link.joint == ArmLink::Joint::kSlide ? link.mass_kg : turning) + link.reflected_inertia();
}

/// M^-1 b by the L D L^T factors of a symmetric, positive definite matrix, of which the lower half is read.
Vector6d solved(const Matrix6d& m, const Vector6d& b) {
  double l[6][6], d[6], inverse[6], x[6];
#pragma GCC unroll 6
  for (int column = 0; column < 6; ++column) {
    double pivot = m(column, column), left = b(column);
#pragma GCC unroll 6
    for (int k = 0; k < column; ++k) {
      pivot -= l[column][k] * l[column][k] * d[k];
      left -= l[column][k] * x[k];
    }
    d[column] = pivot;
    inverse[column] = 1 / pivot;
    x[column] = left;
#pragma GCC unroll 6
    for (int row = column + 1; row < 6; ++row) {
      double value = m(row, column);
#pragma GCC unroll 6
      for (int k = 0; k < column; ++k) value -= l[row][k] * d[k] * l[column][k];
      l[row][column] = value * inverse[column];
    }
  }
#pragma GCC unroll 6
  for (int row = 5; row >= 0; --row) {
    x[row] *= inverse[row];
#pragma GCC unroll 6
    for (int k = row + 1; k < 6; ++k) x[row] -= l[k][row] * x[k];
  }
  return Vector6d(x);
}

void require_slow_enough(const ArmLink& link, double step_s) {
  if (link.joint == ArmLink::Joint::kFixed) return;
  const double most = kLeastDecay * own_inertia(link) / step_s;
  require(link.viscous_friction <= most, "link '" + link.name + "' viscous_friction", link.viscous_friction,
          "must be at most " + printed(most) + ", 2.5 times the inertia about the axis per step");
}

}  // namespace

ArmBase::Load CraftBase::at(const BodyState& state, double time_s) const {
  const Craft::Load load = craft_.load(state, loads_.at(state.world_from_body.orientation), water_, time_s);
  return {craft_.mass(load.submerged), load.wrench_body};
}

Arm::Arm(std::vector<ArmLink> links, double step_s) : body_(std::move(links)) {
  const std::size_t count = body_.size();
  for (const ArmLink& link : body_.links()) {
    require_slow_enough(link, step_s);
    now_.positions.push_back(link.start);
    commands_.push_back(link.strongest > 0 ? JointCommand{JointCommand::Mode::kPosition, link.start}
                                           : JointCommand{JointCommand::Mode::kTorque, 0});
  }
  now_.speeds.resize(count);
  now_.motor_torques.resize(count);
  start_ = next_ = stage_ = sum_ = now_;
  laws_.resize(count);
  drives_.resize(count);
  law_torques_.resize(count);
  link_poses_.resize(count);
  link_velocities_.resize(count);
  wrenches_.fill(Vector6d::Zero());
}

void Arm::add_link_poses(const Pose& world_from_base, std::vector<Pose>& poses) const {
  const std::size_t first = poses.size();
  for (std::size_t k = 0; k < size(); ++k) {
    const ArmLink& link = links()[k];
    const Pose& holder = link.parent == ArmLink::kBase ? world_from_base : poses[first + link.parent];
    poses.push_back(holder * link.parent_from_link_at(position(k)));
  }
}

Arm Arm::with_links(std::vector<ArmLink> links, double step_s) const {
  require(links.size() == size(), "arm.links", links.size(), "cannot be changed");
  for (std::size_t k = 0; k < size(); ++k) {
    const ArmLink& before = this->links()[k];
    require(links[k].joint == before.joint && links[k].parent == before.parent && links[k].name == before.name,
            "arm.links", links[k].name, "its name, parent and kind of joint cannot be changed");
  }
  Arm changed(std::move(links), step_s);
  changed.now_ = now_;
  for (std::size_t k = 0; k < size(); ++k) {
    const ArmLink& link = changed.links()[k];
    changed.now_.positions[k] = std::clamp(now_.positions[k], link.lowest, link.highest);
    JointCommand& kept = changed.commands_[k] = commands_[k];
    using Mode = JointCommand::Mode;
    if (kept.mode == Mode::kPosition) kept.value = std::clamp(kept.value, link.lowest, link.highest);
    if (kept.mode == Mode::kSpeed) kept.value = std::clamp(kept.value, -link.fastest, link.fastest);
    if (kept.mode == Mode::kTorque) kept.value = std::clamp(kept.value, -link.strongest, link.strongest);
  }
  return changed;
}

void Arm::command(std::size_t joint, const JointCommand& command) {
  require(joint < size(), "joint", joint, "must be below " + std::to_string(size()));
  const ArmLink& link = links()[joint];
  const std::string path = "joint '" + link.name + "' ";
  require(link.joint != ArmLink::Joint::kFixed && link.strongest > 0, path + "command", command.value,
          "must go to a joint with a motor");
  using Mode = JointCommand::Mode;
  if (command.mode == Mode::kPosition) {
    require(command.value >= link.lowest && command.value <= link.highest, path + "position", command.value,
            "must be in [" + printed(link.lowest) + ", " + printed(link.highest) + "]");
  } else {
    const double most = command.mode == Mode::kSpeed ? link.fastest : link.strongest;
    require(std::abs(command.value) <= most && std::isfinite(command.value),
            path + (command.mode == Mode::kSpeed ? "speed" : "torque"), command.value,
            "must be in [-" + printed(most) + ", " + printed(most) + "]");
  }
  commands_[joint] = command;
}

void Arm::place(std::size_t joint, double position, double speed) {
  require(joint < size(), "joint", joint, "must be below " + std::to_string(size()));
  const ArmLink& link = links()[joint];
  require(position >= link.lowest && position <= link.highest, "joint '" + link.name + "' position", position,
          "must be in [" + printed(link.lowest) + ", " + printed(link.highest) + "]");
  require(std::abs(speed) < kFastest, "joint '" + link.name + "' speed", speed, "must be finite");
  now_.positions[joint] = position;
  now_.speeds[joint] = speed;
  if (commands_[joint].mode == JointCommand::Mode::kPosition) commands_[joint].value = position;
}

const ArticulatedBody& Arm::placed(const BodyState& base, const WaterField& water, double time_s) {
  body_.place(base, now_.positions, now_.speeds, water, time_s);
  return body_;
}

/// Returns the base's acceleration with the present drives, and sets those of the joints.
Vector6d Arm::accelerate(const ArmBase::Load& load, bool held) {
  const ArticulatedBody::Reaction& reaction = body_.fold(drives_);
  Vector6d acceleration = Vector6d::Zero();
  if (!held) acceleration = solved(load.mass + reaction.inertia, load.wrench - reaction.bias);
  body_.unfold(acceleration);
  wrench_ = -(reaction.inertia * acceleration + reaction.bias);
  return acceleration;
}

void Arm::drive(double step_s) {
  for (std::size_t k = 0; k < size(); ++k) {
    const JointLaw& law = laws_[k];
    drives_[k] = law.at_jump() ? JointDrive{true, (law.jump_speed() - start_.speeds[k]) / step_s}
                               : JointDrive{false, law.flat_torque()};
  }
}

/// Finds how the joints are driven in this step.
Vector6d Arm::solve_joints(const ArmBase::Load& load, bool held, double step_s) {
  for (std::size_t k = 0; k < size(); ++k) {
    if (links()[k].joint == ArmLink::Joint::kFixed) continue;
    laws_[k] = JointLaw(links()[k], commands_[k], start_.positions[k], start_.speeds[k], step_s);
  }
  Vector6d acceleration;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    drive(step_s);
    acceleration = accelerate(load, held);
    // All at once converges sooner; one at a time, the first, always does.
    const bool one_by_one = iteration > static_cast<int>(2 * size());
    bool moves = false;
    for (std::size_t k = 0; k < size(); ++k) {
      if (links()[k].joint == ArmLink::Joint::kFixed) continue;
      law_torques_[k] = body_.torque(k);
      if (moves && one_by_one) continue;
      moves = laws_[k].leave(law_torques_[k], start_.speeds[k] + step_s * body_.acceleration(k)) || moves;
    }
    if (!moves) break;
  }
  return acceleration;
}

void Arm::record_motors() {
  for (std::size_t k = 0; k < size(); ++k) {
    const bool moves = links()[k].joint != ArmLink::Joint::kFixed;
    next_.motor_torques[k] = moves ? laws_[k].motor_torque(law_torques_[k]) : 0;
  }
}

BodyState Arm::advance(const ArmBase& base, const BodyState& state, const WaterField& water, double time_s,
                       double step_s) {
  constexpr std::array kReached = {0.0, 0.5, 0.5, 1.0};
  const bool held = base.held();
  std::array<Rate, 4> rates;
  BodyState at = state;
  stage_.positions = start_.positions;
  stage_.speeds = start_.speeds;
  for (std::size_t k = 0; k < 4; ++k) {
    const double now_s = time_s + kReached[k] * step_s;
    body_.place(at, stage_.positions, stage_.speeds, water, now_s);
    const ArmBase::Load load = base.at(at, now_s);
    Vector6d acceleration;
    if (k == 0) {
      acceleration = solve_joints(load, held, step_s);
      record_motors();
      inertia_ = body_.reaction().inertia;
    } else {
      acceleration = accelerate(load, held);
    }
    rates[k] = rate_at(at, acceleration);
    wrenches_[k] = wrench_;
    for (std::size_t j = 0; j < size(); ++j) {
      const double weight = k == 1 || k == 2 ? 2 : 1;
      sum_.positions[j] = (k == 0 ? 0 : sum_.positions[j]) + weight * stage_.speeds[j];
      sum_.speeds[j] = (k == 0 ? 0 : sum_.speeds[j]) + weight * body_.acceleration(j);
    }
    if (k == 3) break;
    const double ahead_s = kReached[k + 1] * step_s;
    for (std::size_t j = 0; j < size(); ++j) {
      stage_.positions[j] = start_.positions[j] + ahead_s * stage_.speeds[j];
      stage_.speeds[j] = start_.speeds[j] + ahead_s * body_.acceleration(j);
    }
    if (!held) at = moved_at(state, rates[k], ahead_s);
  }
  for (std::size_t j = 0; j < size(); ++j) {
    const ArmLink& link = links()[j];
    next_.positions[j] = std::clamp(start_.positions[j] + step_s * sum_.positions[j] / 6, link.lowest, link.highest);
    next_.speeds[j] = laws_[j].at_jump() ? laws_[j].jump_speed() : start_.speeds[j] + step_s * sum_.speeds[j] / 6;
  }
  if (held) return state;
  const Rate mean = {
      (rates[0].position + 2 * rates[1].position + 2 * rates[2].position + rates[3].position) / 6,
      (rates[0].quaternion + 2 * rates[1].quaternion + 2 * rates[2].quaternion + rates[3].quaternion) / 6,
      (rates[0].velocity + 2 * rates[1].velocity + 2 * rates[2].velocity + rates[3].velocity) / 6};
  return moved_at(state, mean, step_s);
}

void Arm::require_plausible(const char* kind, const std::string& name) const {
  for (std::size_t k = 0; k < size(); ++k) {
    const bool plausible = std::abs(next_.speeds[k]) < kFastest && std::abs(next_.positions[k]) < kFastest;
    if (plausible) continue;
    require(false, std::string(kind) + " '" + name + "' joint '" + links()[k].name + "'", next_.speeds[k],
            "the motion diverged: use a smaller step_s or check the link's coefficients");
  }
}

void Arm::exchange_state(StateArchive& archive) {
  archive.same("joints", size());
  for (std::size_t k = 0; k < size(); ++k) {
    for (std::vector<double>* values : {&now_.positions, &now_.speeds, &now_.motor_torques}) archive((*values)[k]);
    auto mode = static_cast<std::uint64_t>(commands_[k].mode);
    archive(mode);
    archive(commands_[k].value);
    require(mode <= static_cast<std::uint64_t>(JointCommand::Mode::kTorque), "state.joint.mode", mode,
            "must be that of a command");
    commands_[k].mode = static_cast<JointCommand::Mode>(mode);
  }
  next_ = now_;
  require_plausible("state of", "arm");
}

}  // namespace uwsim
