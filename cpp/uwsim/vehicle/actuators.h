#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/allocation.h"
#include "uwsim/vehicle/fin.h"
#include "uwsim/vehicle/thruster.h"

namespace uwsim {

/// What drives and steers a vehicle: either forces and torques straight along its axes, as the paper's, or thrusters;
/// and fins.
struct ActuatorsSpec {
  /// Straight along and about the body axes at full effort [N, N m]; follows at once.
  Vector6d full_wrench_body = Vector6d::Zero();
  std::vector<ThrusterParameters> thrusters;
  std::vector<FinParameters> fins;

  /// Throws InvalidValue that names the field.
  void check() const;
};

/// A vehicle's actuators with their state. Commands are held until the next; what is refused changes nothing.
class Actuators {
 public:
  using Named = std::vector<std::pair<std::string, double>>;

  Actuators() : Actuators(ActuatorsSpec{}) {}
  /// Throws InvalidValue from the spec's check.
  explicit Actuators(const ActuatorsSpec& spec);

  const std::vector<Thruster>& thrusters() const { return thrusters_; }
  const std::vector<Fin>& fins() const { return fins_; }
  /// Axes, surge to yaw, about which an effort does something.
  const std::array<bool, 6>& controllable() const { return controllable_; }
  /// The largest wrenches about single axes in still water, [N, N m]: (2, 6), forward and backward, magnitudes.
  const std::array<Vector6d, 2>& full_wrench_body() const { return full_; }

  /// Surge, sway, heave, roll, pitch, yaw in [-1, 1]. Full effort of one axis alone is the largest wrench about it that
  /// the thrusters give, and the largest deflection of the fins that turn the vehicle about it; together they are
  /// scaled down until nothing saturates. Axes that are not controllable do nothing. Throws InvalidValue beyond.
  void set_effort(const Vector6d& effort);
  const Vector6d& effort() const { return effort_; }
  /// A wrench [N, N m] of the thrusters in still water; one beyond them keeps its direction. Fins stay as they are.
  /// Throws InvalidValue when not finite.
  void set_wrench(const Vector6d& wrench_body);
  /// Commands in [-1, 1] by name, unnamed ones 0; fins stay. Throws InvalidValue.
  void set_thrusters(const Named& commands);
  /// Deflections [rad] by name, unnamed ones 0; thrusters stay. Throws InvalidValue.
  void set_fins(const Named& angles_rad);

  /// Lets a step pass, under power or without: then the thrusters spin down and the fins stay.
  void advance(double step_s, bool powered);
  /// Mean force and torque over the last step (body frame, at the origin). The water's flow and surface are taken at
  /// the origin for all of the vehicle; `submerged` is the hull's share under water, by which straight forces scale.
  Vector6d wrench_body(const BodyState& state, const WaterField& water, double time_s, double submerged) const;
  bool drives_straight() const { return straight_; }

  /// Saves or restores commands and how far the actuators have followed them. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  void share_out(const Vector6d& wrench_body);
  void deflect(const Vector6d& effort);
  void prepare_fins();
  double surface_above(const Pose& world_from_body, const WaterField& water, double time_s) const;

  std::vector<Thruster> thrusters_;
  std::vector<Fin> fins_;
  Allocation allocation_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> fin_angles_rad_;  // of full effort about each axis
  Vector6d full_straight_ = Vector6d::Zero();
  std::array<Vector6d, 2> full_;
  std::array<bool, 6> controllable_{};
  double reach_m_ = 0;  // nothing is farther from the origin
  bool straight_ = false;
  bool powered_ = false;
  Vector6d effort_ = Vector6d::Zero();
  Vector6d straight_wrench_ = Vector6d::Zero();
};

}  // namespace uwsim
