#include "uwsim/sim/telemetry.h"

#include <limits>

#include "uwsim/sim/simulation.h"

namespace uwsim {

Telemetry Simulation::telemetry(std::size_t index) const {
  const Vehicle& shown = vehicle(index);
  const BodyState& state = bodies_.state(shown.body);
  const Vector6d& acceleration = bodies_.acceleration_body(shown.body);
  const Eigen::Vector3d& position = state.world_from_body.position_m;
  Telemetry t;
  t.time_s = time_s();
  t.speed_m_s = state.linear_body_m_s().norm();
  t.angular_speed_rad_s = state.angular_body_rad_s().norm();
  t.linear_acceleration_body_m_s2 = acceleration.head<3>() + state.angular_body_rad_s().cross(state.linear_body_m_s());
  t.acceleration_m_s2 = t.linear_acceleration_body_m_s2.norm();
  t.angular_acceleration_body_rad_s2 = acceleration.tail<3>();
  t.temperature_deg_c = world_.water.temperature_deg_c(position.z());
  t.pressure_pa = world_.water.pressure_pa(position, time_s());
  t.depth_m = world_.water.surface_height_at(position.x(), position.y(), time_s()) - position.z();
  t.distance_to_station_m = (position - station_world_m()).norm();
  t.distance_to_seabed_m =
      scene_->cast({position, -Eigen::Vector3d::UnitZ()}, std::numeric_limits<float>::max()).distance_m;
  t.mission_time_s = shown.battery.mission_time_s(tick_);
  t.battery_percent = shown.battery.charge_percent(tick_);
  t.range_warning = t.distance_to_station_m > spec_.range_warning_m;
  t.proximity_warning = t.distance_to_seabed_m < spec_.proximity_warning_m;
  t.collision_warning = bodies_.in_contact(shown.body);
  return t;
}

BatteryState Simulation::battery(std::size_t index) const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const Battery& battery = vehicle(index).battery;
  const double percent = battery.charge_percent(tick_);
  if (!battery.cells()) return {kUnknown, kUnknown, kUnknown, kUnknown, percent};
  const BatteryCells& cells = *battery.cells();
  return {cells.voltage_v(), cells.current_a(), cells.charge_ah(), cells.spec().capacity_ah, percent};
}

}  // namespace uwsim
