#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/dynamics/rigid_body_world.h"
#include "uwsim/sensors/sensor_rack.h"
#include "uwsim/sonar/acoustic_multibeam.h"
#include "uwsim/sonar/multibeam.h"
#include "uwsim/vehicle/actuators.h"
#include "uwsim/vehicle/craft.h"

namespace uwsim {

struct SonarSpec {
  std::string name;
  MultibeamModel model = em2040(2);
  Pose body_from_mount;
  double elevation_rad = 0;
  std::optional<AcousticSpec> acoustics;  ///< physics mode; without: geometry mode
};

/// Everything that makes a vehicle of a scenario.
struct VehicleSpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  ActuatorsSpec actuators;
  CollisionShape shape = CollisionShape::kHull;
  std::vector<ConvexPiece> collision_pieces_body_m;  ///< of CollisionShape::kPieces
  double friction = 0.5;
  double restitution = 0.1;
  Pose start_world_from_body;
  bool docked = false;  ///< held at its start until released
  std::vector<SensorSpec> sensors;
  std::vector<SonarSpec> sonars;
};

/// A vehicle within a simulation: what it carries and how its mission stands.
struct Vehicle {
  std::string name;
  std::size_t body = 0;  ///< in the RigidBodyWorld
  std::shared_ptr<const Craft> craft;
  Actuators actuators;
  SensorRack sensors;
  std::vector<Multibeam> sonars;
  std::vector<std::shared_ptr<const AcousticMultibeam>> acoustics;  ///< of each sonar; null in geometry mode
  std::vector<std::string> sonar_names;
  std::uint64_t released_tick = 0;  ///< meaningful once released
  bool released = false;
  bool touching = false;
  std::uint64_t collisions = 0;  ///< times it came to touch something
};

/// The paper's vehicle panel.
struct Telemetry {
  double time_s = 0;
  double speed_m_s = 0;
  double angular_speed_rad_s = 0;
  double acceleration_m_s2 = 0;  ///< magnitude of the inertial acceleration
  double temperature_deg_c = 0;
  double pressure_pa = 0;
  double depth_m = 0;
  double distance_to_station_m = 0;
  double distance_to_seabed_m = 0;  ///< straight down; infinity over nothing
  double mission_time_s = 0;        ///< since the release
  double battery_percent = 0;       ///< of the mission time, what is left
  bool range_warning = false;       ///< too far from the station
  bool proximity_warning = false;   ///< too near the seabed
  bool collision_warning = false;   ///< touching something
};

}  // namespace uwsim
