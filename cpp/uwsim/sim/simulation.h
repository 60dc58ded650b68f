#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/rays/ray_scene.h"
#include "uwsim/sim/link.h"
#include "uwsim/sim/saved_state_format.h"
#include "uwsim/sim/tape.h"
#include "uwsim/sim/telemetry.h"
#include "uwsim/sim/vehicle.h"
#include "uwsim/world/wind.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A station that rides on a vehicle, in that vehicle's frame.
struct CarriedStation {
  std::size_t vehicle = 0;
  Eigen::Vector3d position_body_m = Eigen::Vector3d::Zero();
  Pose body_from_docked;  ///< of the vehicle in its dock
};

struct SimulationSpec {
  double step_s = 0.005;
  std::uint64_t seed = 0;
  double mission_time_s = 3600;  ///< how long a battery without cells lasts after a release
  Eigen::Vector3d station_world_m = Eigen::Vector3d::Zero();
  double range_warning_m = 110;
  double proximity_warning_m = 10;
  EngineKind engine = EngineKind::kUwsim;
  Wind wind;
  std::optional<CarriedStation> carried_station;  ///< in place of `station_world_m`

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// One of several pings; see Simulation::ping_together.
struct PingOrder {
  std::size_t vehicle, sonar;
  bool water_column = false;
  PingRows rows{};          ///< where results are written in geometry mode
  AcousticPing acoustic{};  ///< the result in physics mode
};

/// A world, its vehicles and its loose bodies, advanced in fixed steps. In each step, sensors sample, actuators follow
/// their commands while the battery lasts, bodies move, and sonar heads tilt. Reading sensors, pinging and reading
/// telemetry do not advance time, and return the same result if repeated at the same time. Only one thread at a time
/// may use it.
class Simulation {
 public:
  Simulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec);

  /// Adds a vehicle and returns its index. Throws InvalidValue if the spec is invalid or its start is below the ground
  /// or inside a closed solid.
  std::size_t add_vehicle(const VehicleSpec& spec);

  /// Adds a loose body, after all vehicles, and returns its index. Throws InvalidValue like add_vehicle.
  std::size_t add_object(const ObjectSpec& spec);
  /// Lets go of a loose body that a vehicle carries: it keeps the velocity that it has there, and its spring pushes
  /// both apart, so that momentum is conserved, and its energy becomes theirs and the water's that they move; the
  /// joints of an arm count as locked. A docked vehicle does not recoil. Throws InvalidValue for one that is not
  /// loaded.
  void release_object(std::size_t object);
  /// Puts a body back to where its vehicle carries it. Throws InvalidValue unless it is one that was released.
  void load_object(std::size_t object);
  /// False also for an object that no vehicle carries.
  bool object_loaded(std::size_t object) const;
  /// Adds a tether, after all vehicles and objects, which are its bodies in that order, and returns its index. Throws
  /// InvalidValue.
  std::size_t add_tether(const TetherSpec& spec) { return bodies_.add_tether(spec, world_.water, time_s()); }
  std::size_t tethers() const { return bodies_.tethers(); }
  /// Throws std::out_of_range.
  Tether& tether(std::size_t index) { return bodies_.tether(index); }
  std::size_t objects() const { return bodies_.size() - vehicles_.size(); }
  const BodyState& object_state(std::size_t object) const { return bodies_.state(body_of(object)); }
  /// The name of a body by its index: vehicles come first, then objects.
  const std::string& body_name(std::size_t body) const { return bodies_.spec(body).name; }
  /// The index of an object among the bodies.
  std::size_t body_of(std::size_t object) const;
  /// The name of a link of a body's arm; empty for Touch::kNoLink.
  std::string link_name(std::size_t body, std::uint64_t link) const;

  /// Replaces the water, the simulation's spec and the vehicles' specs from the next step on. All state is kept:
  /// motion, commands and samples. `vehicles`: one spec per vehicle, in order, with the same names of parts; start
  /// positions are ignored. If a spec is invalid or has a different step, seed or engine, throws InvalidValue without
  /// changing anything.
  void change(const Water& water, const SimulationSpec& spec, const std::vector<VehicleSpec>& vehicles);

  /// Connects the station, node 0, with the vehicles, nodes 1 + index. Must be called after all vehicles have been
  /// added. Throws InvalidValue.
  void set_link(const LinkSpec& spec);
  bool has_link() const { return link_.has_value(); }
  /// The packets of the link. Throws InvalidValue if there is no link.
  PacketNetwork& link();
  /// Returns how a packet sent now would reach another node.
  Reception link_reception(std::size_t from, std::size_t to) const;

  /// Throws InvalidValue if the motion of a vehicle diverges.
  void step(std::uint64_t count = 1);
  std::uint64_t tick() const { return tick_; }
  /// A number that changes whenever an observation may change: when time, a vehicle's pose or a sonar's elevation
  /// changes.
  std::uint64_t version() const { return version_; }
  std::uint64_t time_ns() const { return tick_ * step_ns_; }
  std::uint64_t step_ns() const { return step_ns_; }
  double time_s() const { return 1e-9 * static_cast<double>(time_ns()); }
  const SimulationSpec& spec() const { return spec_; }

  const BodyState& state(std::size_t vehicle) const;
  /// Where the station is now.
  Eigen::Vector3d station_world_m() const;
  /// Moves the vehicle to a pose immediately, releasing it if it is docked; its propellers keep spinning, and its
  /// sensors keep their samples. Throws InvalidValue for a state that is not finite, more than 1000 km away, faster
  /// than 100 m/s or rad/s, below the ground or inside a closed solid.
  void set_state(std::size_t vehicle, const BodyState& state);
  /// Releases the vehicle from its dock and starts its mission time. Does nothing if it is already released.
  void release(std::size_t vehicle);
  /// Holds the vehicle at a pose, at rest, until it is released again. Its commands are cancelled and its battery is
  /// charged; the next release starts a new mission. Throws InvalidValue for a position below the ground or inside a
  /// closed solid.
  void dock(std::size_t vehicle, const Pose& world_from_body);
  bool released(std::size_t index) const { return vehicle(index).released(); }
  /// The vehicle's thrusters and fins.
  Actuators& actuators(std::size_t index) { return changeable(index).actuators; }
  const Actuators& actuators(std::size_t index) const { return vehicle(index).actuators; }
  /// The number of times the vehicle has come into contact with anything.
  std::uint64_t collisions(std::size_t index) const { return vehicle(index).collisions; }

  bool has_arm(std::size_t index) const { return bodies_.arm(vehicle(index).body) != nullptr; }
  bool feels_wind(std::size_t index) const { return vehicle(index).windage && spec_.wind.blows(); }
  /// The arm of a body: vehicles come first, then objects. Throws InvalidValue if it has none.
  Arm& arm(std::size_t body);
  const BodyState& body_state(std::size_t body) const { return bodies_.state(body); }

  /// Exerts a wrench on a vehicle at its origin [N, N m], besides those by schedule, for a duration, rounded to steps,
  /// or until the next call. Throws InvalidValue for more than 1e9 N or N m and a negative duration.
  void apply_wrench(std::size_t vehicle, const Vector6d& wrench, bool in_world_axes,
                    double duration_s = std::numeric_limits<double>::infinity());
  void apply_object_wrench(std::size_t object, const Vector6d& wrench, bool in_world_axes,
                           double duration_s = std::numeric_limits<double>::infinity());
  /// See RigidBodyWorld::forces and RigidBodyWorld::touches.
  Forces forces(std::size_t vehicle) const;
  const std::vector<Touch>& touches(std::size_t vehicle) const;
  Forces object_forces(std::size_t object) const;
  const std::vector<Touch>& object_touches(std::size_t object) const;
  /// See BuoyantHull::wet_surface.
  WetSurface wet_surface(std::size_t vehicle) const;
  WetSurface object_wet_surface(std::size_t object) const;

  /// Throws std::out_of_range, as do all functions with an index.
  const Vehicle& vehicle(std::size_t index) const;
  Telemetry telemetry(std::size_t vehicle) const;
  BatteryState battery(std::size_t vehicle) const;
  /// Reads a sensor. The reference is valid until the sensor is read again. With `with_noise` false, returns the
  /// present value without errors, rate, latency or drop-outs.
  const Sample& read_sensor(std::size_t vehicle, std::size_t sensor, bool with_noise = true);
  /// Starts collecting the samples that a sensor measures at or after `from_ns`, as they arrive; nullopt stops
  /// collecting.
  void watch_sensor(std::size_t vehicle, std::size_t sensor, std::optional<std::uint64_t> from_ns);
  /// Returns the samples that have arrived since the last call. Throws InvalidValue unless the sensor is watched.
  SampleBatch take_samples(std::size_t vehicle, std::size_t sensor);
  /// Writes a tape at the end of each step at which it is due, until it is detached.
  void attach(std::shared_ptr<Tape> tape);
  void detach(const std::shared_ptr<Tape>& tape) { std::erase(tapes_, tape); }
  void aim(std::size_t vehicle, std::size_t sonar, double elevation_rad);
  const SonarHead& sonar(std::size_t vehicle, std::size_t sonar) const;
  Pose world_from_sonar(std::size_t vehicle, std::size_t sonar) const;
  /// Pings in geometry mode.
  MultibeamPing ping(std::size_t vehicle, std::size_t sonar) const;
  void ping(std::size_t vehicle, std::size_t sonar, const PingRows& rows) const;
  /// Pings in physics mode. Random draws are keyed by seed, vehicle, sonar and tick. Throws InvalidValue in geometry
  /// mode.
  AcousticPing acoustic_ping(std::size_t vehicle, std::size_t sonar, int threads = 1, bool water_column = false) const;
  /// Makes several pings on up to `threads` threads: each as `ping` and `acoustic_ping` make it alone.
  void ping_together(std::span<PingOrder* const> orders, int threads) const;
  /// The surfaces of the world, without vehicles.
  const RayScene& scene() const { return *scene_; }
  /// The fixed world, with its plants as they lean now.
  RayScene scene_with_plants() const;
  /// The surroundings of the vehicle's instruments: the world, and all other vehicles, objects, arms, its
  /// own as well, and tethers at their present poses. Valid until time advances or a vehicle is moved.
  RayScene scene_around(std::size_t vehicle) const;
  /// Returns the poses of all arms' links that have a surface, vehicle by vehicle, each arm's links in order.
  std::vector<Pose> link_surfaces() const;
  /// Returns link_surfaces(), followed by the poses of the tubes of all tethers (tether_tubes.h).
  std::vector<Pose> attached_surfaces() const;
  /// All vehicles, objects, schools, then arms and tethers, at their present poses, for RayScene::with.
  const MovingBodies& vehicles_for_rays() const;
  const Water& water() const { return world_.water; }

  /// Returns, as bytes, everything that future steps depend on, except for the parameters of the simulation. If a
  /// simulation built in the same way restores these bytes, its steps and samples are bitwise identical. `notes` are
  /// stored as well.
  std::string save_state(const StateOrigin& origin, const std::string& notes = {});
  /// Restores a saved state and returns its notes. If the state is damaged or of another origin, throws InvalidValue
  /// without changing anything.
  std::string restore_state(std::string_view bytes, const StateOrigin& origin);

 private:
  void exchange_state(StateArchive& archive);
  void exchange_applied(StateArchive& archive);
  void exchange_details(StateArchive& archive);
  void exchange_vehicle(StateArchive& archive, Vehicle& vehicle) const;
  Vehicle equipped(const VehicleSpec& vehicle, const SimulationSpec& spec, const Water& water) const;
  Vehicle& changeable(std::size_t index);
  VehicleSnapshot snapshot(const Vehicle& vehicle) const;
  void require_free(const std::string& path, const Eigen::Vector3d& position_world_m) const;
  RayScene scene_around(const Vehicle& vehicle) const;
  void add_attached_surfaces(std::vector<Pose>& poses) const;
  void step_once();
  void drive(Vehicle& vehicle);
  Vector6d wind_load(const Vehicle& vehicle, const Wind& wind) const;
  void carry_docked();
  Cargo& cargo_of(std::size_t object);
  BodyState carried_state(const Carrying& carrying) const;
  void add_cargo(std::size_t object, const Carrying& carrying);
  void set_loaded(std::size_t object, bool loaded);
  void carry_cargo();
  void spring_apart(std::size_t object);
  std::vector<ArmLink> links_left(std::size_t vehicle, std::vector<ArmLink> links) const;
  void exchange_cargo(StateArchive& archive);
  void transmit();
  void receive();
  void join_instruments();
  Transducer transducer(std::size_t node) const;

  static constexpr auto kUnplaced = std::numeric_limits<std::uint64_t>::max();  // a version that never occurs

  World world_;
  SoundSpeedProfile sound_;  // sound speed of its water
  std::shared_ptr<const RayScene> scene_;
  SimulationSpec spec_;
  std::uint64_t step_ns_;
  std::uint64_t tick_ = 0;
  std::uint64_t version_ = 0;
  RigidBodyWorld bodies_;
  std::vector<Vehicle> vehicles_;
  std::vector<LooseObject> objects_;
  std::optional<Link> link_;
  std::vector<std::shared_ptr<Tape>> tapes_;
  std::shared_ptr<MovingBodies> hulls_;       // the bodies as ray targets
  mutable std::uint64_t hulls_version_;       // the version for which they were placed
  mutable std::shared_ptr<const Sway> sway_;  // of plants; null if they stand still
  mutable std::uint64_t sway_tick_;
  mutable std::vector<Pose> attached_;  // in vehicles_for_rays
};

}  // namespace uwsim
