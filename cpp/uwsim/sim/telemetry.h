#pragma once

#include <Eigen/Core>

namespace uwsim {

/// A vehicle's instrument panel, as in the paper.
struct Telemetry {
  double time_s = 0;
  double speed_m_s = 0;
  double angular_speed_rad_s = 0;
  double acceleration_m_s2 = 0;                                             ///< magnitude of the inertial acceleration
  Eigen::Vector3d linear_acceleration_body_m_s2 = Eigen::Vector3d::Zero();  ///< the inertial acceleration, body axes
  Eigen::Vector3d angular_acceleration_body_rad_s2 = Eigen::Vector3d::Zero();
  double temperature_deg_c = 0;
  double pressure_pa = 0;
  double depth_m = 0;  ///< straight up to the surface, with its waves and tide; negative above it
  double distance_to_station_m = 0;
  double distance_to_seabed_m = 0;  ///< straight down; infinity if there is no surface below
  double mission_time_s = 0;        ///< since the release
  double battery_percent = 0;       ///< remaining fraction of the battery's charge or of the mission time
  bool range_warning = false;       ///< whether the vehicle is too far from the station
  bool proximity_warning = false;   ///< whether the vehicle is too near the seabed
  bool collision_warning = false;   ///< whether the vehicle is in contact with anything
};

/// The readings of a battery's monitor; if the battery is a mission time, all but the percentage are NaN.
struct BatteryState {
  double voltage_v = 0;    ///< at the terminals
  double current_a = 0;    ///< drawn from the terminals
  double charge_ah = 0;    ///< remaining charge
  double capacity_ah = 0;  ///< charge of a full battery
  double percent = 0;      ///< remaining usable charge; 0 once the battery has switched off
};

}  // namespace uwsim
