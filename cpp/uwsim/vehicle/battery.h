#pragma once

#include <algorithm>
#include <cstdint>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"

namespace uwsim {

/// The vehicle's energy store, modelled as the paper does: a mission time. It is full until the vehicle is released,
/// then drains evenly whatever the thrusters do, and is empty `lasting_s` later: thrusters stop and fins stay where
/// they are. Docking charges it, at once. All times are ticks of the simulation, `step_ns` long.
class Battery {
 public:
  Battery() = default;
  Battery(double lasting_s, std::uint64_t step_ns) : lasting_s_(lasting_s), step_ns_(step_ns) {}

  /// Called when the vehicle is released: the mission time starts.
  void start_mission(std::uint64_t tick) {
    mission_started_ = true;
    start_tick_ = tick;
  }
  /// Called when the vehicle is docked: its battery is charged at once.
  void end_mission() { mission_started_ = false; }
  bool mission_started() const { return mission_started_; }

  /// Time since the release; 0 before it [s].
  double mission_time_s(std::uint64_t tick) const {
    return mission_started_ ? 1e-9 * static_cast<double>((tick - start_tick_) * step_ns_) : 0;
  }
  /// Whether thrusters and fins have power: from the release until the battery is empty.
  bool has_power(std::uint64_t tick) const { return mission_started_ && mission_time_s(tick) < lasting_s_; }
  /// The remaining part of the mission time, from 100 to 0.
  double charge_percent(std::uint64_t tick) const {
    return 100 * std::clamp(1 - mission_time_s(tick) / lasting_s_, 0.0, 1.0);
  }

  /// Saves or restores whether and when the mission started, at `tick`. Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick) {
    archive(mission_started_);
    archive(start_tick_);
    require(start_tick_ <= tick, "state.released_tick", start_tick_, "must not lie ahead");
  }

 private:
  double lasting_s_ = 3600;
  std::uint64_t step_ns_ = 0;
  std::uint64_t start_tick_ = 0;  // meaningful once the mission has started
  bool mission_started_ = false;
};

}  // namespace uwsim
