#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/sim/state_seal.h"
#include "uwsim/sim/vehicle.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/world.h"

namespace uwsim {

struct SimulationSpec {
  double step_s = 0.005;
  std::uint64_t seed = 0;
  double mission_time_s = 3600;  ///< the battery: thrusters stop this long after the release
  Eigen::Vector3d station_world_m = Eigen::Vector3d::Zero();
  double range_warning_m = 110;
  double proximity_warning_m = 10;

  void check() const;
};

/// A world with vehicles in it, advanced by fixed steps. One step: actuators from efforts and battery, then bodies.
/// Sensors, sonars and telemetry look at the present state, do not advance time, and repeat at one time.
/// One thread at a time.
class Simulation {
 public:
  Simulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec);

  /// Throws InvalidValue where the spec breaks a rule, or starts under the ground or inside a closed solid.
  std::size_t add_vehicle(const VehicleSpec& spec);

  /// Throws InvalidValue when a state stops being finite.
  void step(std::uint64_t count = 1);
  std::uint64_t tick() const { return tick_; }
  /// Changes whenever something may look different: time, a vehicle's place, a sonar's aim.
  std::uint64_t version() const { return version_; }
  std::uint64_t time_ns() const { return tick_ * step_ns_; }
  double time_s() const { return 1e-9 * static_cast<double>(time_ns()); }
  const SimulationSpec& spec() const { return spec_; }

  const BodyState& state(std::size_t vehicle) const;
  /// Puts the vehicle somewhere at once; its propellers go on turning, and what its sensors have sampled stays sampled.
  /// Throws InvalidValue when not finite, absurdly far away or fast, under the ground or inside a closed solid.
  void set_state(std::size_t vehicle, const BodyState& state);
  /// Leaves the station; does nothing when already free.
  void release(std::size_t vehicle);
  bool released(std::size_t index) const { return vehicle(index).released; }
  /// The vehicle's thrusters and fins, to command and to look at.
  Actuators& actuators(std::size_t index) { return changeable(index).actuators; }
  const Actuators& actuators(std::size_t index) const { return vehicle(index).actuators; }
  std::uint64_t collisions(std::size_t index) const { return vehicle(index).collisions; }

  /// Throws std::out_of_range, as all that take an index.
  const Vehicle& vehicle(std::size_t index) const;
  Telemetry telemetry(std::size_t vehicle) const;
  /// Holds until the next read of this sensor. Without noise: the present, without rate, delay and drop-outs.
  const Sample& read_sensor(std::size_t vehicle, std::size_t sensor, bool with_noise = true);
  void aim(std::size_t vehicle, std::size_t sonar, double elevation_rad);
  MultibeamPing ping(std::size_t vehicle, std::size_t sonar) const;
  /// In physics mode. Draws are keyed by seed, vehicle, sonar and tick. Throws InvalidValue in geometry mode.
  AcousticPing acoustic_ping(std::size_t vehicle, std::size_t sonar, int threads = 1) const;
  bool in_physics_mode(std::size_t vehicle, std::size_t sonar) const;
  void ping(std::size_t vehicle, std::size_t sonar, const PingRows& rows) const;
  Pose world_from_sonar(std::size_t vehicle, std::size_t sonar) const;
  const Multibeam& sonar(std::size_t vehicle, std::size_t sonar) const;
  const RayScene& scene() const { return *scene_; }
  const Water& water() const { return world_.water; }

  /// All that the future depends on beside what the simulation was made of, as bytes: taken back by one that was made
  /// alike it gives the same steps and samples to the last bit. `notes` are kept with it.
  std::string save_state(const StateOrigin& origin, const std::string& notes = {});
  /// Returns the notes. Throws InvalidValue, and changes nothing, for a state that is damaged or was saved elsewhere.
  std::string restore_state(std::string_view bytes, const StateOrigin& origin);

 private:
  void exchange_state(StateArchive& archive);
  Vehicle& changeable(std::size_t index);
  double mission_time_s(const Vehicle& vehicle) const;
  Moment moment(const Vehicle& vehicle) const;
  std::shared_ptr<const AcousticMultibeam> acoustics_of(const SonarSpec& sonar, const std::string& vehicle) const;
  void require_free(const std::string& path, const Eigen::Vector3d& position_world_m) const;
  void step_once();
  void drive(Vehicle& vehicle);

  World world_;
  std::shared_ptr<const RayScene> scene_;
  SimulationSpec spec_;
  std::uint64_t step_ns_;
  std::uint64_t tick_ = 0;
  std::uint64_t version_ = 0;
  RigidBodyWorld bodies_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace uwsim
