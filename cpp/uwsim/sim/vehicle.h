#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/dynamics/rigid_body_world.h"
#include "uwsim/sensors/sensor_rack.h"
#include "uwsim/sonar/sonar_head.h"
#include "uwsim/vehicle/actuators.h"
#include "uwsim/vehicle/battery.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/vehicle/windage.h"

namespace uwsim {

/// A wrench that something else exerts on a body, at the body's origin, from one tick until before another.
struct AppliedWrench {
  static constexpr double kLargest = 1e9;  ///< N and N m
  Vector6d wrench = Vector6d::Zero();      ///< [N, N m]
  bool in_world_axes = false;              ///< otherwise, axes turn with the body
  std::uint64_t from_tick = 0, until_tick = 0;
};

/// The pushes on a body from outside: those by schedule, and the last command.
struct Pushes {
  std::vector<AppliedWrench> scheduled;
  AppliedWrench commanded;

  Loads at(std::uint64_t tick) const;
  /// Replaces the command. Throws InvalidValue, which names the body, for more than 1e9 N or N m and a negative
  /// duration.
  void command(const std::string& body, const Vector6d& wrench, bool in_world_axes, std::uint64_t tick,
               double duration_s, double step_s);
  /// Saves or restores the command. Throws InvalidValue.
  void exchange_state(StateArchive& archive);
};

/// The parameters from which a vehicle is built.
struct VehicleSpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  ActuatorsSpec actuators;
  CollisionShape shape = CollisionShape::kHull;
  std::vector<ConvexPiece> collision_pieces_body_m;  ///< for CollisionShape::kPieces
  double friction = 0.5;
  double restitution = 0.1;
  Pose start_world_from_body;
  bool docked = false;  ///< held at its start until it is released
  std::vector<SensorSpec> sensors;
  std::vector<SonarSpec> sonars;
  std::optional<BatterySpec> battery;   ///< empty: the simulation's mission time
  std::vector<AppliedWrench> wrenches;  ///< that act on it, by schedule
  std::vector<ArmLink> arm;             ///< empty: it has none
  std::optional<Windage> windage;       ///< empty: it feels no wind

  BodySpec body() const { return {name, craft, shape, friction, restitution, collision_pieces_body_m, arm}; }
};

/// How a vehicle carries a loose body until it is released.
struct Carrying {
  std::size_t vehicle = 0;
  std::size_t link = 0;  ///< that is fixed to the vehicle, and has the body's mass and water
  Pose body_from_object;
  Eigen::Vector3d along_body = Eigen::Vector3d::UnitX();  ///< where its spring pushes the body when it is released
  double spring_j = 0;                                    ///< the spring's energy
};

/// A loose body: a vehicle's body without equipment.
struct ObjectSpec {
  BodySpec body;
  BodyState start;
  std::vector<AppliedWrench> wrenches;  ///< that act on it, by schedule
  std::optional<Carrying> carrying;     ///< by which a vehicle carries it at the start, instead of `start`
};

/// The role of a body that a vehicle carries or has carried.
struct Cargo {
  Carrying carrying;
  ArmLink link;  ///< as it is while loaded
  bool loaded = true;
};

/// A loose body in a simulation, except for the state of its body.
struct LooseObject {
  Pushes pushes;
  std::optional<Cargo> cargo = {};  ///< empty: no vehicle carries it
};

/// A vehicle in a simulation: its equipment and state, except for the state of its body.
struct Vehicle {
  std::string name;
  std::size_t body = 0;  ///< index in the RigidBodyWorld
  std::shared_ptr<const Craft> craft;
  Actuators actuators;
  SensorRack sensors;
  std::vector<SonarHead> sonars;
  Battery battery;
  bool touching = false;
  std::uint64_t collisions = 0;  ///< how often it has come into contact with anything
  Pushes pushes;
  std::optional<Windage> windage;

  /// A mission starts when the vehicle leaves its dock.
  bool released() const { return battery.mission_started(); }
};

}  // namespace uwsim
