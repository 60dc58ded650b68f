#include "uwsim/dynamics/joint_law.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sign(double value) { return value > 0 ? 1 : (value < 0 ? -1 : 0); }

/// Infinity times zero is zero here.
double times_sign(double size, double value) { return value == 0 ? 0 : size * sign(value); }

double asked_speed(const ArmLink& link, const JointCommand& command, double position, double step_s) {
  const double speed = command.mode == JointCommand::Mode::kSpeed
                           ? command.value
                           : (command.value - position) / std::max(link.response_s, step_s);
  return std::clamp(speed, -link.fastest, link.fastest);
}

}  // namespace

JointLaw::JointLaw(const ArmLink& link, const JointCommand& command, double position, double speed, double step_s)
    : coulomb_(link.coulomb_friction) {
  // A stop is reached from afar at the step's end, and held at rest once it is reached.
  const double highest = std::max(0.0, link.highest - position) / step_s;
  const double lowest = std::min(0.0, link.lowest - position) / step_s;
  if (std::isfinite(lowest)) add_jump(lowest);
  if (std::isfinite(highest)) add_jump(highest);
  if (coulomb_ > 0) add_jump(0);
  if (command.mode == JointCommand::Mode::kTorque) {
    given_ = command.value;
  } else if (link.strongest > 0) {
    strongest_ = link.strongest;
    target_ = std::clamp(asked_speed(link, command, position, step_s), lowest, highest);
    add_jump(target_);
  }
  for (std::size_t k = 0; k <= count_; ++k) {
    double at = 0;
    if (count_ > 0) at = k == 0 ? jumps_[0] - 1 : (k == count_ ? jumps_[k - 1] + 1 : (jumps_[k - 1] + jumps_[k]) / 2);
    const double stop = at < lowest ? kInfinity : (at > highest ? -kInfinity : 0);
    flats_[k] = stop != 0 ? stop : given_ + times_sign(strongest_, target_ - at) - times_sign(coulomb_, at);
  }
  while (region_ / 2 < count_ && speed >= jumps_[region_ / 2]) {
    region_ += speed == jumps_[region_ / 2] ? 1 : 2;
    if (at_jump()) break;
  }
  while (!at_jump() && std::isinf(flat_torque())) region_ = flat_torque() > 0 ? region_ + 1 : region_ - 1;
}

/// Keeps the jumps in order, each once.
void JointLaw::add_jump(double speed) {
  std::size_t place = count_;
  while (place > 0 && jumps_[place - 1] > speed) --place;
  if (place > 0 && jumps_[place - 1] == speed) return;
  for (std::size_t k = count_; k > place; --k) jumps_[k] = jumps_[k - 1];
  jumps_[place] = speed;
  ++count_;
}

bool JointLaw::leave(double torque, double end_speed) {
  const std::size_t k = region_ / 2;
  if (at_jump()) {
    if (torque > flats_[k]) {
      --region_;
    } else if (torque < flats_[k + 1]) {
      ++region_;
    } else {
      return false;
    }
    return true;
  }
  if (k < count_ && end_speed > jumps_[k]) {
    ++region_;
  } else if (k > 0 && end_speed < jumps_[k - 1]) {
    --region_;
  } else {
    return false;
  }
  return true;
}

JointLaw::Point JointLaw::point_at(double mixed, double scale) const {
  for (std::size_t k = 0; k < count_; ++k) {
    if (mixed < jumps_[k] - scale * flats_[k]) return {false, 0, flats_[k]};
    if (mixed <= jumps_[k] - scale * flats_[k + 1]) return {true, jumps_[k], 0};
  }
  return {false, 0, flats_[count_]};
}

double JointLaw::motor_torque(double torque) const {
  if (strongest_ == 0) return given_;
  if (!at_jump()) return region_ / 2 == 0 || jumps_[region_ / 2 - 1] < target_ ? strongest_ : -strongest_;
  const double speed = jump_speed();
  if (speed != target_) return times_sign(strongest_, target_ - speed);
  const double friction = speed == 0 ? std::clamp(torque, -coulomb_, coulomb_) : -times_sign(coulomb_, speed);
  return std::clamp(torque - friction, -strongest_, strongest_);
}

}  // namespace uwsim
