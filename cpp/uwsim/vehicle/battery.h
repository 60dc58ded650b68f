#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/vehicle/battery_cells.h"

namespace uwsim {

/// The vehicle's energy store. It begins to drain when the vehicle is released; once it is empty, thrusters stop and
/// fins stay where they are. Docking recharges it instantly. Without cells, it is modelled as in the paper, as a
/// mission time: it drains at a constant rate, regardless of the thrusters, and is empty `lasting_s` after the release.
/// All times are ticks of the simulation, `step_ns` long.
class Battery {
 public:
  Battery() = default;
  Battery(double lasting_s, std::uint64_t step_ns) : lasting_s_(lasting_s), step_ns_(step_ns) {}
  /// Throws InvalidValue: see BatterySpec::check.
  Battery(const BatterySpec& cells, std::uint64_t step_ns) : cells_(cells), step_ns_(step_ns) {}

  /// Starts the mission time. Called when the vehicle is released.
  void start_mission(std::uint64_t tick) {
    mission_started_ = true;
    start_tick_ = tick;
  }
  /// Charges the battery instantly. Called when the vehicle is docked.
  void end_mission() {
    mission_started_ = false;
    if (cells_) cells_->charge_fully();
  }
  bool mission_started() const { return mission_started_; }

  /// Time since the release; 0 before the release [s].
  double mission_time_s(std::uint64_t tick) const {
    return mission_started_ ? 1e-9 * static_cast<double>((tick - start_tick_) * step_ns_) : 0;
  }
  /// Supplies thrusters and fins for the step at `tick`: from the release until the battery is empty.
  Supply supply(std::uint64_t tick, const ElectricalLoad& load) {
    if (!cells_) return {mission_started_ && mission_time_s(tick) < lasting_s_, {}};
    return mission_started_ ? cells_->supply(load, 1e-9 * static_cast<double>(step_ns_)) : cells_->rest();
  }
  /// The remaining charge or mission time, from 100 to 0 [%].
  double charge_percent(std::uint64_t tick) const {
    if (cells_) return cells_->charge_percent();
    return 100 * std::clamp(1 - mission_time_s(tick) / lasting_s_, 0.0, 1.0);
  }
  /// Empty if the battery is a mission time.
  const std::optional<BatteryCells>& cells() const { return cells_; }

  /// Saves or restores whether and when the mission started, and the state of the cells. `tick` is the current tick.
  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick) {
    archive(mission_started_);
    archive(start_tick_);
    require(start_tick_ <= tick, "state.released_tick", start_tick_, "must not lie ahead");
    if (cells_) cells_->exchange_state(archive);
  }

 private:
  std::optional<BatteryCells> cells_;
  double lasting_s_ = 3600;
  std::uint64_t step_ns_ = 0;
  std::uint64_t start_tick_ = 0;  // meaningful once the mission has started
  bool mission_started_ = false;
};

}  // namespace uwsim
