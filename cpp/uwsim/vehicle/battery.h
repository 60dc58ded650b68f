#pragma once

#include <algorithm>
#include <cstdint>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"

namespace uwsim {

/// The vehicle's energy store, modelled as in the paper by a mission time. It is full until the vehicle is released,
/// then drains at a constant rate regardless of thrust, and is empty `lasting_s` later: thrusters stop and fins stay in
/// position. Docking charges it instantly. All times are simulation ticks, each `step_ns` long.
class Battery {
 public:
  Battery() = default;
  Battery(double lasting_s, std::uint64_t step_ns) : lasting_s_(lasting_s), step_ns_(step_ns) {}

  /// Starts the mission time. Called when the vehicle is released.
  void start_mission(std::uint64_t tick) {
    mission_started_ = true;
    start_tick_ = tick;
  }
  /// Charges the battery instantly. Called when the vehicle is docked.
  void end_mission() { mission_started_ = false; }
  bool mission_started() const { return mission_started_; }

  /// Time since the release; 0 before the release [s].
  double mission_time_s(std::uint64_t tick) const {
    return mission_started_ ? 1e-9 * static_cast<double>((tick - start_tick_) * step_ns_) : 0;
  }
  /// Whether thrusters and fins have power, which they do from the release until the battery is empty.
  bool has_power(std::uint64_t tick) const { return mission_started_ && mission_time_s(tick) < lasting_s_; }
  /// The remaining fraction of the mission time, from 100 to 0.
  double charge_percent(std::uint64_t tick) const {
    return 100 * std::clamp(1 - mission_time_s(tick) / lasting_s_, 0.0, 1.0);
  }

  /// Saves or restores whether the mission has started, and when, at the current `tick`. Throws InvalidValue.
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
