#include "uwsim/sim/tape.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

/// The first tick at or after the next multiple of a period after `tick`.
std::uint64_t tick_after(std::uint64_t tick, std::uint64_t period_ns, std::uint64_t step_ns) {
  const std::uint64_t periods = tick * step_ns / period_ns + 1;
  return (periods * period_ns + step_ns - 1) / step_ns;
}

void append_motion(const Simulation& sim, std::size_t vehicle, std::vector<double>& row) {
  const auto put = [&row](const auto& numbers) { row.insert(row.end(), numbers.begin(), numbers.end()); };
  const BodyState& state = sim.state(vehicle);
  put(state.world_from_body.position_m);
  put(state.world_from_body.orientation.coeffs());
  put(state.linear_body_m_s());
  put(state.angular_body_rad_s());
  for (const SonarHead& sonar : sim.vehicle(vehicle).sonars) row.push_back(sonar.elevation_rad());
}

}  // namespace

void Tape::begin(const Simulation& sim) {
  next_tick_ = std::numeric_limits<std::uint64_t>::max();
  for (Track& track : tracks_) {
    track.next_tick = tick_after(sim.tick(), track.period_ns, sim.step_ns());
    next_tick_ = std::min(next_tick_, track.next_tick);
  }
}

void Tape::write(Simulation& sim) {
  const std::uint64_t tick = sim.tick(), now_ns = sim.time_ns();
  next_tick_ = std::numeric_limits<std::uint64_t>::max();
  for (Track& track : tracks_) {
    if (tick >= track.next_tick) {
      track.next_tick = tick_after(tick, track.period_ns, sim.step_ns());
      SampleBatch& rows = track.rows;
      std::uint64_t stamp_ns = now_ns;
      bool valid = true;
      if (track.sensor) {
        const Sample& sample = sim.read_sensor(*track.vehicle, *track.sensor);
        rows.values.insert(rows.values.end(), sample.values.begin(), sample.values.end());
        stamp_ns = sample.stamp_ns;
        valid = sample.valid;
      } else if (track.vehicle) {
        append_motion(sim, *track.vehicle, rows.values);
      }
      rows.stamps_ns.push_back(stamp_ns);
      rows.arrivals_ns.push_back(now_ns);
      rows.valid.push_back(valid);
    }
    next_tick_ = std::min(next_tick_, track.next_tick);
  }
}

SampleBatch Tape::take(std::size_t track) { return std::exchange(tracks_.at(track).rows, {}); }

}  // namespace uwsim
