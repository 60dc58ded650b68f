#pragma once

#include <array>
#include <cstddef>

#include "uwsim/dynamics/arm_link.h"

namespace uwsim {

/// A joint's task until the next command.
struct JointCommand {
  enum class Mode : std::uint64_t { kPosition, kSpeed, kTorque };
  Mode mode = Mode::kPosition;
  double value = 0;  ///< rad or m; per s; N m or N of the motor, at the joint
};

/// The torque at a joint in a step, as a function of its speed at the step's end: motor, Coulomb friction and stops. It
/// never grows with speed, and is constant but for a few jumps: friction at rest, the motor's controller at the speed
/// that it asks for, and the stops at the speeds that reach them within the step. At a jump the joint has that speed,
/// and any torque within the jump.
class JointLaw {
 public:
  JointLaw() = default;
  JointLaw(const ArmLink& link, const JointCommand& command, double position, double speed, double step_s);

  bool at_jump() const { return region_ % 2 == 1; }
  double jump_speed() const { return jumps_[region_ / 2]; }
  /// The torque between two jumps.
  double flat_torque() const { return flats_[region_ / 2]; }
  /// Moves to the next region if the torque at a jump, or the speed between two, is out of this one. Returns whether it
  /// has moved.
  bool leave(double torque, double end_speed);
  /// The speed and the torque of the law at which speed - `scale` torque is `mixed`: exactly one point, as the torque
  /// never grows with speed.
  struct Point {
    bool at_jump;
    double speed, torque;  ///< the speed at a jump, the torque between two; the other is unused
  };
  Point point_at(double mixed, double scale) const;
  /// The motor's part of the torque at the joint.
  double motor_torque(double torque) const;

 private:
  void add_jump(double speed);

  static constexpr std::size_t kMost = 4;

  std::array<double, kMost> jumps_{};
  std::array<double, kMost + 1> flats_{};  // torques below, between and above the jumps
  std::size_t count_ = 0;
  std::size_t region_ = 0;  // 2 k: the k-th flat; 2 k + 1: the k-th jump
  double given_ = 0, target_ = 0, strongest_ = 0, coulomb_ = 0;
};

}  // namespace uwsim
