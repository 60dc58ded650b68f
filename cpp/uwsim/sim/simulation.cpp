#include "uwsim/sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kWorldEnd_m = 1e6;
constexpr double kFastest = 100;  // m/s and rad/s

template <typename Items>
auto& item(Items& items, std::size_t index, const char* what) {
  if (index < items.size()) return items[index];
  throw std::out_of_range(std::string(what) + " = " + std::to_string(index) + ": must be below " +
                          std::to_string(items.size()));
}

template <typename Specs>
void require_unique_names(const Specs& specs, const std::string& path) {
  for (auto a = specs.begin(); a != specs.end(); ++a) {
    const bool repeats = std::any_of(specs.begin(), a, [&](const auto& b) { return b.name == a->name; });
    require(!repeats, path, a->name, "must be unique");
  }
}

}  // namespace

void SimulationSpec::check() const {
  require(step_s >= 1e-5 && step_s <= 0.02, "step_s", step_s, "must be in [0.00001, 0.02] s");
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
  require(scene_ != nullptr, "scene", "none", "must be a RayScene");
}

std::size_t Simulation::add_vehicle(const VehicleSpec& spec) {
  for (const Vehicle& other : vehicles_) require(other.name != spec.name, "vehicles.name", spec.name, "must be unique");
  require_unique_names(spec.sensors, "vehicle.sensors.name");
  require_unique_names(spec.sonars, "vehicle.sonars.name");
  require_free("vehicle '" + spec.name + "' start", spec.start_world_from_body.position_m);
  Vehicle vehicle;
  vehicle.name = spec.name;
  vehicle.craft = spec.craft;
  vehicle.actuators = Actuators(spec.actuators);
  vehicle.sensors = SensorRack(spec.sensors, spec_.seed, spec.name, step_ns_);
  for (const SonarSpec& sonar : spec.sonars) {
    sonar.model.check();
    vehicle.sonars.emplace_back(sonar.model, sonar.body_from_mount);
    vehicle.sonars.back().point(sonar.elevation_rad);
    vehicle.sonar_names.push_back(sonar.name);
    vehicle.acoustics.push_back(acoustics_of(sonar, spec.name));
  }
  BodyState state;
  state.world_from_body = spec.start_world_from_body;
  vehicle.body = bodies_.add_body(
      {spec.name, spec.craft, spec.shape, spec.friction, spec.restitution, spec.collision_pieces_body_m}, state);
  bodies_.hold(vehicle.body, spec.docked);
  vehicle.released = !spec.docked;
  vehicle.released_tick = tick_;
  vehicles_.push_back(std::move(vehicle));
  return vehicles_.size() - 1;
}

std::shared_ptr<const AcousticMultibeam> Simulation::acoustics_of(const SonarSpec& sonar,
                                                                  const std::string& vehicle) const {
  if (!sonar.acoustics) return nullptr;
  const RandomStream stream(spec_.seed, vehicle + "/" + sonar.name);
  return std::make_shared<const AcousticMultibeam>(sonar.model, *sonar.acoustics, world_.water,
                                                   world_.water.bottom_depth_m, stream);
}

void Simulation::step(std::uint64_t count) {
  for (std::uint64_t k = 0; k < count; ++k) step_once();
}

void Simulation::step_once() {
  for (Vehicle& vehicle : vehicles_) {
    if (vehicle.sensors.due(tick_)) vehicle.sensors.keep(moment(vehicle));
  }
  for (Vehicle& vehicle : vehicles_) drive(vehicle);
  bodies_.step(world_.water, time_s());
  for (Vehicle& vehicle : vehicles_) {
    const bool touches = bodies_.in_contact(vehicle.body);
    if (touches && !vehicle.touching) ++vehicle.collisions;
    vehicle.touching = touches;
    for (Multibeam& sonar : vehicle.sonars) sonar.advance(spec_.step_s);
  }
  ++tick_;
  ++version_;
}

void Simulation::drive(Vehicle& vehicle) {
  const bool powered = vehicle.released && mission_time_s(vehicle) < spec_.mission_time_s;
  vehicle.actuators.advance(spec_.step_s, powered);
  if (!vehicle.released) return;  // held: nothing moves it
  const BodyState& state = bodies_.state(vehicle.body);
  const Actuators& actuators = vehicle.actuators;
  const double submerged = actuators.drives_straight()
                               ? vehicle.craft->submerged_fraction(state.world_from_body, world_.water, time_s())
                               : 1;
  bodies_.set_wrench(vehicle.body, actuators.wrench_body(state, world_.water, time_s(), submerged));
}

double Simulation::mission_time_s(const Vehicle& vehicle) const {
  return vehicle.released ? 1e-9 * static_cast<double>((tick_ - vehicle.released_tick) * step_ns_) : 0;
}

const Vehicle& Simulation::vehicle(std::size_t index) const { return item(vehicles_, index, "vehicle"); }
Vehicle& Simulation::changeable(std::size_t index) { return item(vehicles_, index, "vehicle"); }

const BodyState& Simulation::state(std::size_t index) const { return bodies_.state(vehicle(index).body); }

/// Nothing pushes out what starts inside a thing: what touches a surface is pushed off the side it is on.
void Simulation::require_free(const std::string& path, const Eigen::Vector3d& position) const {
  const double bed_m = world_.terrain() ? world_.terrain()->height_at(position.x(), position.y()) : -kWorldEnd_m;
  require(!(position.z() <= bed_m), path, position.transpose(), "must be above the ground");
  const Solid* const around = world_.solid_around(position);
  if (around != nullptr) require(false, path, position.transpose(), "must be outside '" + around->name + "'");
}

void Simulation::set_state(std::size_t index, const BodyState& state) {
  Vehicle& moved = changeable(index);
  const std::string path = "vehicle '" + moved.name + "'";
  const Eigen::Vector3d& position = state.world_from_body.position_m;
  require(state.world_from_body.position_m.allFinite() && state.world_from_body.orientation.coeffs().allFinite() &&
              state.velocity_body.allFinite(),
          path + " state", "non-finite", "must be finite");
  require(position.cwiseAbs().maxCoeff() <= kWorldEnd_m, path + " position_m", position.transpose(),
          "must be within 1000 km of the origin");
  require(state.velocity_body.cwiseAbs().maxCoeff() <= kFastest, path + " velocity_body",
          state.velocity_body.transpose(), "must be at most 100 m/s and rad/s");
  require_free(path + " position_m", position);
  BodyState placed = state;
  if (!moved.released) placed.velocity_body.setZero();  // held: nothing moves it
  bodies_.set_state(moved.body, placed);
  moved.touching = false;
  ++version_;
}

void Simulation::release(std::size_t index) {
  Vehicle& docked = changeable(index);
  if (docked.released) return;
  docked.released = true;
  docked.released_tick = tick_;
  bodies_.hold(docked.body, false);
}

Telemetry Simulation::telemetry(std::size_t index) const {
  const Vehicle& shown = vehicle(index);
  const BodyState& state = bodies_.state(shown.body);
  const Vector6d& acceleration = bodies_.acceleration_body(shown.body);
  const Eigen::Vector3d& position = state.world_from_body.position_m;
  Telemetry t;
  t.time_s = time_s();
  t.speed_m_s = state.linear_body_m_s().norm();
  t.angular_speed_rad_s = state.angular_body_rad_s().norm();
  t.acceleration_m_s2 = (acceleration.head<3>() + state.angular_body_rad_s().cross(state.linear_body_m_s())).norm();
  t.temperature_deg_c = world_.water.temperature_deg_c(position.z());
  t.pressure_pa = world_.water.pressure_pa(position, time_s());
  t.depth_m = Water::depth_m(position.z());
  t.distance_to_station_m = (position - spec_.station_world_m).norm();
  t.distance_to_seabed_m =
      scene_->cast({position, -Eigen::Vector3d::UnitZ()}, std::numeric_limits<float>::max()).distance_m;
  t.mission_time_s = mission_time_s(shown);
  t.battery_percent = 100 * std::clamp(1 - t.mission_time_s / spec_.mission_time_s, 0.0, 1.0);
  t.range_warning = t.distance_to_station_m > spec_.range_warning_m;
  t.proximity_warning = t.distance_to_seabed_m < spec_.proximity_warning_m;
  t.collision_warning = bodies_.in_contact(shown.body);
  return t;
}

Moment Simulation::moment(const Vehicle& vehicle) const {
  return {tick_, bodies_.state(vehicle.body), bodies_.acceleration_body(vehicle.body),
          bodies_.in_contact(vehicle.body)};
}

const Sample& Simulation::read_sensor(std::size_t index, std::size_t sensor, bool with_noise) {
  Vehicle& reader = changeable(index);
  const Surroundings around{*scene_, world_.water, spec_.station_world_m};
  NoisySensor& instrument = reader.sensors.at(sensor);
  return with_noise ? instrument.read(moment(reader), around) : instrument.read_true(moment(reader), around);
}

void Simulation::aim(std::size_t index, std::size_t sonar, double elevation_rad) {
  item(changeable(index).sonars, sonar, "sonar").aim(elevation_rad);
  ++version_;
}

MultibeamPing Simulation::ping(std::size_t index, std::size_t sonar) const {
  return item(vehicle(index).sonars, sonar, "sonar").ping(*scene_, world_.water, state(index).world_from_body);
}

bool Simulation::in_physics_mode(std::size_t index, std::size_t sonar) const {
  return item(vehicle(index).acoustics, sonar, "sonar") != nullptr;
}

AcousticPing Simulation::acoustic_ping(std::size_t index, std::size_t sonar, int threads) const {
  const auto& acoustics = item(vehicle(index).acoustics, sonar, "sonar");
  require(acoustics != nullptr, "sonar.mode", "geometry", "must be physics");
  const BodyState& moving = state(index);
  const Pose body_from_sonar = vehicle(index).sonars[sonar].body_from_sonar();
  const Eigen::Vector3d rate_body = moving.angular_body_rad_s();
  const Eigen::Vector3d head_body = moving.linear_body_m_s() + rate_body.cross(body_from_sonar.position_m);
  const HeadMotion motion{moving.world_from_body.direction(head_body), moving.world_from_body.direction(rate_body)};
  return acoustics->ping(*scene_, moving.world_from_body * body_from_sonar, motion, tick_, threads);
}

void Simulation::ping(std::size_t index, std::size_t head, const PingRows& rows) const {
  sonar(index, head).ping(*scene_, world_.water, state(index).world_from_body, rows);
}

const Multibeam& Simulation::sonar(std::size_t index, std::size_t head) const {
  return item(vehicle(index).sonars, head, "sonar");
}

Pose Simulation::world_from_sonar(std::size_t index, std::size_t sonar) const {
  return state(index).world_from_body * item(vehicle(index).sonars, sonar, "sonar").body_from_sonar();
}

std::string Simulation::save_state(const StateOrigin& origin, const std::string& notes) {
  StateArchive archive;
  std::string kept = notes;
  archive(kept);
  exchange_state(archive);
  return sealed_state(archive.bytes(), origin);
}

std::string Simulation::restore_state(std::string_view bytes, const StateOrigin& origin) {
  StateArchive archive(unsealed_state(bytes, origin));
  std::string notes;
  archive(notes);
  StateArchive before;
  exchange_state(before);
  try {
    exchange_state(archive);
    archive.finish();
  } catch (...) {
    StateArchive back(before.bytes());
    exchange_state(back);
    throw;
  }
  ++version_;
  return notes;
}

void Simulation::exchange_state(StateArchive& archive) {
  archive.same("step_ns", step_ns_);
  archive.same("seed", spec_.seed);
  archive(tick_);
  archive.same("vehicles", vehicles_.size());
  for (Vehicle& vehicle : vehicles_) {
    archive.same("vehicle", vehicle.name);
    archive(vehicle.released);
    archive(vehicle.released_tick);
    archive(vehicle.touching);
    archive(vehicle.collisions);
    require(vehicle.released_tick <= tick_, "state.released_tick", vehicle.released_tick, "must not lie ahead");
    vehicle.actuators.exchange_state(archive);
    vehicle.sensors.exchange_state(archive);
    archive.same("sonars", vehicle.sonars.size());
    for (Multibeam& sonar : vehicle.sonars) sonar.exchange_state(archive);
  }
  bodies_.exchange_state(archive);
}

}  // namespace uwsim
