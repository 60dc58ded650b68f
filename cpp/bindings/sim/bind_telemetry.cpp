#include <cstdio>
#include <string>

#include "bindings/core/record.h"
#include "bindings/sim/binders.h"

namespace uwsim::bindings {
namespace {

std::string describe(const Telemetry& t) {
  char text[400];
  std::snprintf(text, sizeof text,
                "Telemetry(t = %.3f s: depth %.2f m, speed %.2f m/s, %.2f m above the bed, %.1f m from the station, "
                "%.1f deg C, %.0f Pa, battery %.1f %%%s%s%s)",
                t.time_s, t.depth_m, t.speed_m_s, t.distance_to_seabed_m, t.distance_to_station_m, t.temperature_deg_c,
                t.pressure_pa, t.battery_percent, t.range_warning ? ", RANGE" : "",
                t.proximity_warning ? ", PROXIMITY" : "", t.collision_warning ? ", COLLISION" : "");
  return text;
}

}  // namespace

void bind_telemetry(py::module_& m, py::class_<OwnedSimulation>& simulation) {
  Record<Telemetry>(m, "Telemetry", "A vehicle's instrument panel, as in the paper.")
      .field("time_s", &Telemetry::time_s)
      .field("speed_m_s", &Telemetry::speed_m_s)
      .field("angular_speed_rad_s", &Telemetry::angular_speed_rad_s)
      .field("acceleration_m_s2", &Telemetry::acceleration_m_s2)
      .field("linear_acceleration_body_m_s2", &Telemetry::linear_acceleration_body_m_s2, "(3,), without gravity")
      .field("angular_acceleration_body_rad_s2", &Telemetry::angular_acceleration_body_rad_s2, "(3,)")
      .field("temperature_deg_c", &Telemetry::temperature_deg_c)
      .field("pressure_pa", &Telemetry::pressure_pa, "absolute")
      .field("depth_m", &Telemetry::depth_m, "straight up to the surface, with its waves and tide; negative above it")
      .field("distance_to_station_m", &Telemetry::distance_to_station_m)
      .field("distance_to_seabed_m", &Telemetry::distance_to_seabed_m,
             "straight down; inf if there is no surface below")
      .field("mission_time_s", &Telemetry::mission_time_s, "since the release")
      .field("battery_percent", &Telemetry::battery_percent,
             "remaining fraction of the battery's charge or of the mission time")
      .field("range_warning", &Telemetry::range_warning)
      .field("proximity_warning", &Telemetry::proximity_warning)
      .field("collision_warning", &Telemetry::collision_warning)
      .described_by(&describe)
      .done();

  Record<BatteryState>(m, "BatteryState", "The readings of a battery's monitor; NaN for quantities of a mission time.")
      .field("voltage_v", &BatteryState::voltage_v, "at the terminals")
      .field("current_a", &BatteryState::current_a, "out of the terminals")
      .field("charge_ah", &BatteryState::charge_ah, "what remains")
      .field("capacity_ah", &BatteryState::capacity_ah, "of a full battery")
      .field("percent", &BatteryState::percent, "remaining usable charge; 0 once the battery has switched off")
      .done();

  simulation
      .def(
          "telemetry",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with_briefly([&](Simulation& s) { return s.telemetry(v); });
          },
          py::arg("vehicle"))
      .def(
          "battery",
          [](OwnedSimulation& o, std::size_t v) { return o.with_briefly([&](Simulation& s) { return s.battery(v); }); },
          py::arg("vehicle"));
}

}  // namespace uwsim::bindings
