#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/vehicle/allocation.h"
#include "uwsim/vehicle/fin.h"
#include "uwsim/vehicle/supply.h"
#include "uwsim/vehicle/thruster.h"

namespace uwsim {

/// The actuators of a vehicle: fins, and either thrusters or, as in the paper, a direct wrench (forces and torques
/// along the body axes, without actuators that produce them).
struct ActuatorsSpec {
  /// The direct wrench at full effort on all axes [N, N m]; it follows commands without delay.
  Vector6d full_wrench_body = Vector6d::Zero();
  std::vector<ThrusterParameters> thrusters;
  std::vector<FinParameters> fins;

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// A vehicle's actuators and their state. A command remains in effect until the next one; a command that is refused
/// changes nothing.
class Actuators {
 public:
  using Named = std::vector<std::pair<std::string, double>>;  ///< values by name of a thruster or fin

  Actuators() : Actuators(ActuatorsSpec{}) {}
  /// Throws InvalidValue; see ActuatorsSpec::check.
  explicit Actuators(const ActuatorsSpec& spec);

  const std::vector<Thruster>& thrusters() const { return thrusters_; }
  const std::vector<Fin>& fins() const { return fins_; }
  /// For each axis, surge to yaw, whether an effort about it has an effect.
  const std::array<bool, 6>& controllable() const { return controllable_; }
  /// Magnitudes of the largest wrenches along or about each axis alone in still water: (2, 6), forward and backward [N,
  /// N m].
  const std::array<Vector6d, 2>& full_wrench_body() const { return full_; }

  /// The distribution of wrenches to thrusters.
  const Allocation& allocation() const { return allocation_; }
  /// Torques of the fins at full effort about each axis alone, per 1 N/m^2 of dynamic pressure in flow from ahead; 0
  /// for axes about which the fins do not turn the vehicle [m^3].
  Vector6d fin_torque_body() const;

  /// Sets the effort in surge, sway, heave, roll, pitch, yaw, each in [-1, 1]. Full effort on one axis alone is the
  /// largest wrench along or about it that the thrusters can produce, and the largest deflection of the fins that turn
  /// the vehicle about it. Efforts on several axes are scaled down together until nothing saturates. Efforts on
  /// uncontrollable axes are ignored. Throws InvalidValue beyond [-1, 1].
  void set_effort(const Vector6d& effort);
  const Vector6d& effort() const { return effort_; }
  /// Sets the wrench that the thrusters are to produce in still water [N, N m]; a wrench beyond their limits is scaled
  /// down in its direction. Fins keep their command. Throws InvalidValue if the wrench is not finite.
  void set_wrench(const Vector6d& wrench_body);
  /// Sets thruster commands in [-1, 1] by name; thrusters that are not named get 0, fins keep their command. Throws
  /// InvalidValue.
  void set_thrusters(const Named& commands);
  /// Sets fin deflections [rad] by name; fins that are not named get 0, thrusters keep their command. Throws
  /// InvalidValue.
  void set_fins(const Named& angles_rad);

  /// Applies the restored commands again if they were saved by actuators with different parameters: an effort is
  /// reallocated, and direct wrenches and fins are limited to their ranges.
  void renew_commands();

  /// The current that the thrusters would draw at the end of the next step; empty unless all thrusters have sheets.
  /// Valid until the next call.
  ElectricalLoad load(double step_s);
  /// Advances the state by one step. Without power, thrusters spin down and fins stay in position.
  void advance(double step_s, const Supply& supply);
  /// Mean force and torque over the last step (body frame, at the origin). The flow and the surface height at the
  /// origin are used for the whole vehicle. `submerged`: the submerged fraction of the hull, which scales a direct
  /// wrench.
  Vector6d wrench_body(const BodyState& state, const WaterField& water, double time_s, double submerged) const;
  bool has_direct_wrench() const { return has_direct_wrench_; }

  /// Saves or restores commands and the actuators' response to them. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  void allocate_effort();
  void allocate(const Vector6d& wrench_body);
  void deflect(const Vector6d& effort);
  void allocate_fins();
  double surface_above_origin_m(const Pose& world_from_body, const WaterField& water, double time_s) const;

  std::vector<Thruster> thrusters_;
  std::vector<Fin> fins_;
  std::vector<std::optional<std::size_t>> jets_;  // for each fin, the thruster in whose slipstream it may be
  Allocation allocation_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> fin_angles_rad_;  // for full effort on each axis
  Vector6d full_direct_wrench_ = Vector6d::Zero();
  std::array<Vector6d, 2> full_;
  std::array<bool, 6> controllable_{};
  double radius_m_ = 0;  // of a sphere about the origin that encloses all thrusters and fins
  bool has_direct_wrench_ = false;
  bool powered_ = false;
  std::vector<double> load_a_;  // by voltage of the thrusters' sheets
  Vector6d effort_ = Vector6d::Zero();
  Vector6d direct_wrench_ = Vector6d::Zero();
};

}  // namespace uwsim
