#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwsim/sim/simulation.h"

namespace uwsim {

/// Everything from which one simulation of a batch is built, apart from terrain and solids. Members with equal
/// parameters share their vehicles' specs.
struct MemberSpec {
  Water water;
  SimulationSpec simulation;
  std::vector<std::shared_ptr<const VehicleSpec>> vehicles;
  std::optional<LinkSpec> link;
  std::vector<std::shared_ptr<const ObjectSpec>> objects = {};
  std::vector<TetherSpec> tethers = {};
};

/// Destinations for the position and motion of one vehicle in each member. Each array has one row per member.
struct MotionRows {
  std::uint64_t* times_ns;    ///< (n,)
  double* positions_world_m;  ///< (n, 3)
  double* orientations_xyzw;  ///< (n, 4)
  double* velocities_body;    ///< (n, 6) [m/s, rad/s]
  std::uint64_t* collisions;  ///< (n,)
  std::uint8_t* released;     ///< (n,) 0 or 1
};

/// Destinations for the samples of one sensor in each member.
struct SampleRows {
  double* values;  ///< (n, width)
  std::uint64_t* stamps_ns;
  std::uint8_t* valid;
};

/// Destinations for the pings of one sonar in each member, in physics mode: (n, beams) for each field of AcousticPing,
/// and (n, beams, 3) for points.
struct AcousticRows {
  PingRows echoes;
  float *snr_db, *travel_time_s, *deviation_m, *vertical_deviation_m, *horizontal_deviation_m;
  std::uint8_t* detections;
};

/// n independent simulations of one world, advanced and read together by several threads. They share terrain, solids
/// and the search structures for these. Each has its own water, seed and vehicles, but vehicles and instruments have
/// the same names in all members. A member is equivalent to a separate Simulation built from the same spec: results are
/// bitwise identical, regardless of the number of threads. Only one thread at a time may call these functions.
///
/// If a member throws, the others continue. Afterwards, the error of the first failing member is rethrown, prefixed
/// with the member's index, such as batch[3].
class Batch {
 public:
  /// Throws InvalidValue, like Simulation.
  Batch(const World& world, std::shared_ptr<const RayScene> scene, std::vector<MemberSpec> members, int threads);

  std::size_t size() const { return members_.size(); }
  /// Returns a member. It is shared, so that an observer can still use it after the batch has restarted that member.
  /// Throws std::out_of_range.
  const std::shared_ptr<Simulation>& member(std::size_t index) { return members_.at(index); }

  /// Restarts the chosen members. `specs`: new specs for these members; empty to reuse the present ones. On error,
  /// throws without changing anything.
  void restart(std::span<const std::size_t> chosen, std::vector<MemberSpec> specs = {});
  /// See Simulation::release and Simulation::set_state. If a member cannot be placed, throws InvalidValue after the
  /// other members have been placed.
  void release(std::size_t vehicle, std::span<const std::size_t> chosen);
  void set_states(std::size_t vehicle, std::span<const std::size_t> chosen, std::span<const BodyState> states);

  /// Sets the effort of one vehicle in each member: (n, 6), see Actuators::set_effort. On error, throws InvalidValue
  /// without changing any member.
  void set_efforts(std::size_t vehicle, std::span<const double> efforts);
  /// Commands one vehicle in each member: wrenches (n, 6), see Actuators::set_wrench; values by thruster or fin,
  /// (n, names.size()), see Actuators::set_thrusters and set_fins. On error, throws InvalidValue after the other
  /// members have been commanded.
  void set_wrenches(std::size_t vehicle, std::span<const double> wrenches_body);
  void set_thrusters(std::size_t vehicle, std::span<const std::string> names, std::span<const double> commands);
  void set_fins(std::size_t vehicle, std::span<const std::string> names, std::span<const double> angles_rad);
  void step(std::uint64_t count);
  /// Advances each member by its own number of steps; counts: (n,).
  void step_each(std::span<const std::uint64_t> counts);

  void motion(std::size_t vehicle, const MotionRows& rows) const;
  /// The number of values in a reading. Throws std::out_of_range.
  std::size_t reading_width(std::size_t vehicle, std::size_t sensor) const;
  void read_sensor(std::size_t vehicle, std::size_t sensor, bool with_noise, const SampleRows& rows);
  /// Pings in geometry mode: rows of n * beams, and the heads' poses (n, 4, 4), in row-major order.
  void ping(std::size_t vehicle, std::size_t sonar, const PingRows& rows, double* world_from_sonar) const;
  /// Pings in physics mode; results have the same layout as above. Throws InvalidValue for a member in geometry mode.
  void acoustic_ping(std::size_t vehicle, std::size_t sonar, const AcousticRows& rows, double* world_from_sonar) const;

 private:
  std::shared_ptr<Simulation> made(const MemberSpec& spec) const;
  template <typename Work>
  void each(std::span<const std::size_t> chosen, int threads, const Work& work) const;
  template <typename Ping>
  void ping_each(std::size_t vehicle, std::size_t sonar, double* world_from_sonar, const Ping& ping) const;

  World world_;
  std::shared_ptr<const RayScene> scene_;
  int threads_;
  std::vector<MemberSpec> specs_;
  std::vector<std::shared_ptr<Simulation>> members_;
  std::vector<std::size_t> all_;  // 0, 1, ... n - 1
};

}  // namespace uwsim
