#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/sensors/sample_watch.h"

namespace uwsim {

class Simulation;

/// Rows that a simulation appends at multiples of a period, at the end of the steps that reach them, so that a reader
/// of all of them need not interrupt its steps. Each track has the rows of one vehicle's motion, of one sensor, or of
/// the time alone, as a read at that tick returns them. Appending allocates only when a track outgrows its memory.
class Tape {
 public:
  /// The first numbers of a row of motion; the elevations of the vehicle's sonars follow [rad].
  static constexpr std::size_t kMotion = 13;

  /// Adds a track and returns its index. Motion: position [m], orientation x, y, z, w, linear [m/s] and angular
  /// velocity [rad/s] in body axes, then the sonars' elevations.
  std::size_t add_time(std::uint64_t period_ns) { return add({period_ns, {}, {}}); }
  std::size_t add_motion(std::size_t vehicle, std::uint64_t period_ns) { return add({period_ns, vehicle, {}}); }
  std::size_t add_sensor(std::size_t vehicle, std::size_t sensor, std::uint64_t period_ns) {
    return add({period_ns, vehicle, sensor});
  }
  /// Becomes due at the next multiples after the simulation's tick.
  void begin(const Simulation& sim);
  bool due(std::uint64_t tick) const { return tick >= next_tick_; }
  /// Appends the rows that are due.
  void write(Simulation& sim);
  /// Returns the rows of a track since the last call; arrivals are the times of reading, and stamps, unless it is a
  /// sensor's, are the same. Throws std::out_of_range.
  SampleBatch take(std::size_t track);

 private:
  struct Track {
    std::uint64_t period_ns;
    std::optional<std::size_t> vehicle, sensor;
    std::uint64_t next_tick = 0;
    SampleBatch rows = {};
  };
  std::size_t add(Track track) {
    tracks_.push_back(std::move(track));
    return tracks_.size() - 1;
  }

  std::vector<Track> tracks_;
  std::uint64_t next_tick_ = 0;
};

}  // namespace uwsim
