#include "uwsim/sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

void SimulationSpec::check() const {
  require(step_s >= 1e-5 && step_s <= 0.1, "step_s", step_s, "must be in [0.00001, 0.1] s");
  require(std::isfinite(mission_time_s) && mission_time_s > 0, "mission_time_s", mission_time_s, "must be positive");
  require(station_world_m.allFinite(), "station.position_m", station_world_m.transpose(), "must be finite");
  require(range_warning_m > 0, "warnings.range_m", range_warning_m, "must be positive");
  require(proximity_warning_m > 0, "warnings.proximity_m", proximity_warning_m, "must be positive");
}

Simulation::Simulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec)
    : world_(world),
      scene_(std::move(scene)),
      spec_((spec.check(), spec)),
      step_ns_(static_cast<std::uint64_t>(std::llround(spec.step_s * 1e9))),
      bodies_(world, spec.step_s) {
  world_.water.check();
}

std::size_t Simulation::add_vehicle(const VehicleSpec& spec) {
  for (const Vehicle& other : vehicles_) require(other.name != spec.name, "vehicles.name", spec.name, "must be unique");
  Vehicle vehicle;
  vehicle.name = spec.name;
  vehicle.drive = spec.drive;
  for (const SensorSpec& sensor : spec.sensors) vehicle.sensors.emplace_back(sensor, spec_.seed, spec.name);
  for (const SonarSpec& sonar : spec.sonars) {
    vehicle.sonars.emplace_back(em2040(sonar.model), sonar.body_from_mount);
    vehicle.sonars.back().aim(sonar.elevation_rad);
    vehicle.sonar_names.push_back(sonar.name);
  }
  BodyState state;
  state.world_from_body = spec.start_world_from_body;
  vehicle.body = bodies_.add_body({spec.name, spec.craft, spec.shape, spec.friction, spec.restitution}, state);
  bodies_.hold(vehicle.body, spec.docked);
  vehicle.released = !spec.docked;
  vehicle.released_tick = tick_;
  vehicles_.push_back(std::move(vehicle));
  return vehicles_.size() - 1;
}

void Simulation::step(std::uint64_t count) {
  const Fluid fluid{world_.water.density_kg_m3, world_.water.gravity_m_s2, world_.water.current_world_m_s};
  for (std::uint64_t k = 0; k < count; ++k) step_once(fluid);
}

void Simulation::step_once(const Fluid& fluid) {
  for (const Vehicle& vehicle : vehicles_) {
    const bool powered = vehicle.released && mission_time_s(vehicle) < spec_.mission_time_s;
    bodies_.set_wrench(vehicle.body, powered ? vehicle.drive.wrench_body(vehicle.effort) : Vector6d::Zero().eval());
  }
  bodies_.step(fluid);
  for (Vehicle& vehicle : vehicles_) {
    const bool touches = bodies_.in_contact(vehicle.body);
    if (touches && !vehicle.touching) ++vehicle.collisions;
    vehicle.touching = touches;
  }
  ++tick_;
}

double Simulation::mission_time_s(const Vehicle& vehicle) const {
  return vehicle.released ? 1e-9 * static_cast<double>((tick_ - vehicle.released_tick) * step_ns_) : 0;
}

const BodyState& Simulation::state(std::size_t vehicle) const { return bodies_.state(vehicles_.at(vehicle).body); }

void Simulation::set_state(std::size_t vehicle, const BodyState& state) {
  require(state.world_from_body.position_m.allFinite() && state.world_from_body.orientation.coeffs().allFinite() &&
              state.velocity_body.allFinite(),
          "vehicle '" + vehicles_.at(vehicle).name + "' state", "non-finite", "must be finite");
  bodies_.set_state(vehicles_.at(vehicle).body, state);
}

void Simulation::release(std::size_t index) {
  Vehicle& vehicle = vehicles_.at(index);
  if (vehicle.released) return;
  vehicle.released = true;
  vehicle.released_tick = tick_;
  bodies_.hold(vehicle.body, false);
}

void Simulation::set_effort(std::size_t vehicle, const Vector6d& effort) {
  static constexpr std::array<const char*, 6> kAxes = {"surge", "sway", "heave", "roll", "pitch", "yaw"};
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    const double value = effort(static_cast<Eigen::Index>(axis));
    require(std::abs(value) <= 1, std::string("effort.") + kAxes[axis], value, "must be in [-1, 1]");
  }
  vehicles_.at(vehicle).effort = effort;
}

Telemetry Simulation::telemetry(std::size_t index) const {
  const Vehicle& vehicle = vehicles_.at(index);
  const BodyState& state = bodies_.state(vehicle.body);
  const Vector6d& acceleration = bodies_.acceleration_body(vehicle.body);
  const Eigen::Vector3d& position = state.world_from_body.position_m;
  Telemetry t;
  t.time_s = time_s();
  t.speed_m_s = state.linear_body_m_s().norm();
  t.angular_speed_rad_s = state.angular_body_rad_s().norm();
  t.acceleration_m_s2 = (acceleration.head<3>() + state.angular_body_rad_s().cross(state.linear_body_m_s())).norm();
  t.temperature_deg_c = world_.water.temperature_deg_c(position.z());
  t.pressure_pa = world_.water.pressure_pa(position.z());
  t.depth_m = Water::depth_m(position.z());
  t.distance_to_station_m = (position - spec_.station_world_m).norm();
  t.distance_to_seabed_m =
      scene_->cast({position, -Eigen::Vector3d::UnitZ()}, std::numeric_limits<float>::max()).distance_m;
  t.mission_time_s = mission_time_s(vehicle);
  t.battery_percent = 100 * std::clamp(1 - t.mission_time_s / spec_.mission_time_s, 0.0, 1.0);
  t.range_warning = t.distance_to_station_m > spec_.range_warning_m;
  t.proximity_warning = t.distance_to_seabed_m < spec_.proximity_warning_m;
  t.collision_warning = bodies_.in_contact(vehicle.body);
  return t;
}

std::vector<double> Simulation::read_sensor(std::size_t index, std::size_t sensor, bool with_noise) const {
  const Vehicle& vehicle = vehicles_.at(index);
  const SensorInput input{bodies_.state(vehicle.body), bodies_.acceleration_body(vehicle.body), *scene_, world_.water};
  return vehicle.sensors.at(sensor).read(input, tick_, with_noise);
}

void Simulation::aim(std::size_t vehicle, std::size_t sonar, double elevation_rad) {
  vehicles_.at(vehicle).sonars.at(sonar).aim(elevation_rad);
}

MultibeamPing Simulation::ping(std::size_t vehicle, std::size_t sonar) const {
  return vehicles_.at(vehicle).sonars.at(sonar).ping(*scene_, world_.water, state(vehicle).world_from_body);
}

Pose Simulation::world_from_sonar(std::size_t vehicle, std::size_t sonar) const {
  return state(vehicle).world_from_body * vehicles_.at(vehicle).sonars.at(sonar).body_from_sonar();
}

}  // namespace uwsim
