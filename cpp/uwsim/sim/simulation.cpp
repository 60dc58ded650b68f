#include "uwsim/sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/sim/arm_surfaces.h"
#include "uwsim/sim/tether_tubes.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

/// Returns items[index]. Throws std::out_of_range naming `what`.
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
  wind.check();
  require(!carried_station || carried_station->position_body_m.allFinite(), "station.position_m", "non-finite",
          "must be finite");
  require(range_warning_m > 0, "warnings.range_m", range_warning_m, "must be positive");
  require(proximity_warning_m > 0, "warnings.proximity_m", proximity_warning_m, "must be positive");
}

Simulation::Simulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec)
    : world_((world.water.check(), world)),
      sound_(sound_speed_profile(world_.water)),
      scene_(std::move(scene)),
      spec_((spec.check(), spec)),
      step_ns_(static_cast<std::uint64_t>(std::llround(spec.step_s * 1e9))),
      bodies_(world, spec.step_s, spec.engine),
      hulls_(std::make_shared<MovingBodies>(world.labels_end(), world.schools())),
      hulls_version_(kUnplaced),
      sway_tick_(kUnplaced) {
  require(scene_ != nullptr, "scene", "none", "must be a RayScene");
}

std::size_t Simulation::add_vehicle(const VehicleSpec& spec) {
  require(objects() == 0, "vehicles", spec.name, "must be added before objects");
  for (const Vehicle& other : vehicles_) require(other.name != spec.name, "vehicles.name", spec.name, "must be unique");
  require_free("vehicle '" + spec.name + "' start", spec.start_world_from_body.position_m);
  Vehicle vehicle = equipped(spec, spec_, world_.water);
  BodyState state;
  state.world_from_body = spec.start_world_from_body;
  vehicle.body = bodies_.add_body(spec.body(), state);
  bodies_.hold(vehicle.body, spec.docked);
  if (!spec.docked) vehicle.battery.start_mission(tick_);
  hulls_->add(spec.craft->hull().mesh_body());
  hulls_version_ = kUnplaced;
  vehicles_.push_back(std::move(vehicle));
  return vehicles_.size() - 1;
}

std::size_t Simulation::add_object(const ObjectSpec& spec) {
  for (std::size_t k = 0; k < bodies_.size(); ++k)
    require(body_name(k) != spec.body.name, "objects.name", spec.body.name, "must be unique");
  if (!spec.carrying) require_free("object '" + spec.body.name + "' start", spec.start.world_from_body.position_m);
  bodies_.add_body(spec.body, spec.start);
  objects_.push_back({{spec.wrenches, {}}});
  if (spec.carrying) add_cargo(objects() - 1, *spec.carrying);
  hulls_->add(spec.body.craft->hull().mesh_body());
  hulls_version_ = kUnplaced;
  return objects() - 1;
}

/// Creates a vehicle without a body.
Vehicle Simulation::equipped(const VehicleSpec& from, const SimulationSpec& spec, const Water& water) const {
  require_unique_names(from.sensors, "vehicle.sensors.name");
  require_unique_names(from.sonars, "vehicle.sonars.name");
  Vehicle vehicle;
  vehicle.name = from.name;
  vehicle.craft = from.craft;
  vehicle.actuators = Actuators(from.actuators);
  vehicle.pushes.scheduled = from.wrenches;
  if (from.windage) from.windage->check();
  vehicle.windage = from.windage;
  vehicle.sensors = SensorRack(from.sensors, spec.seed, from.name, step_ns_);
  vehicle.sensors.use_link(link_ && link_->spec.modem.kind == LinkKind::kModem);
  for (const SonarSpec& sonar : from.sonars) {
    vehicle.sonars.emplace_back(sonar, water, RandomStream(spec.seed, stream_name(from.name, sonar.name)));
  }
  if (!from.battery) {
    vehicle.battery = Battery(spec.mission_time_s, step_ns_);
    return vehicle;
  }
  vehicle.battery = Battery(*from.battery, step_ns_);
  const auto volts = vehicle.actuators.load(spec.step_s).voltages_v;
  require(
      !volts.empty() && volts.front() <= from.battery->cutoff_v && volts.back() >= from.battery->open_circuit_v.back(),
      "battery", from.name, "its voltages must lie within those of the sheets of all thrusters");
  return vehicle;
}

void Simulation::step(std::uint64_t count) {
  for (std::uint64_t k = 0; k < count; ++k) step_once();
}

void Simulation::step_once() {
  for (Vehicle& vehicle : vehicles_) {
    if (vehicle.sensors.collection_due(tick_)) {
      vehicle.sensors.collect(snapshot(vehicle), {scene_around(vehicle), world_.water, sound_, &world_});
    }
    if (vehicle.sensors.due(tick_)) {
      const VehicleSnapshot now = snapshot(vehicle);
      const bool among_bodies = vehicle.sensors.casts_rays(now);  // placing them takes time
      vehicle.sensors.record(now, {among_bodies ? scene_around(vehicle) : *scene_, world_.water, sound_});
    }
  }
  if (link_) transmit();
  for (Vehicle& vehicle : vehicles_) drive(vehicle);
  for (std::size_t k = 0; k < objects_.size(); ++k) bodies_.apply(vehicles_.size() + k, objects_[k].pushes.at(tick_));
  bodies_.step(world_.water, time_s());
  if (spec_.carried_station) carry_docked();
  carry_cargo();
  for (Vehicle& vehicle : vehicles_) {
    const bool touches = bodies_.in_contact(vehicle.body);
    if (touches && !vehicle.touching) ++vehicle.collisions;
    vehicle.touching = touches;
    for (SonarHead& sonar : vehicle.sonars) sonar.advance(spec_.step_s);
  }
  ++tick_;
  ++version_;
  if (link_) receive();
  for (const std::shared_ptr<Tape>& tape : tapes_) {
    if (tape->due(tick_)) tape->write(*this);
  }
}

void Simulation::drive(Vehicle& vehicle) {
  vehicle.actuators.advance(spec_.step_s, vehicle.battery.supply(tick_, vehicle.actuators.load(spec_.step_s)));
  if (!vehicle.released()) return;  // a docked vehicle is held
  const BodyState& state = bodies_.state(vehicle.body);
  const Actuators& actuators = vehicle.actuators;
  const double submerged = actuators.has_direct_wrench()
                               ? vehicle.craft->submerged_fraction(state.world_from_body, world_.water, time_s())
                               : 1;
  bodies_.set_wrench(vehicle.body, actuators.wrench_body(state, world_.water, time_s(), submerged));
  Loads loads = vehicle.pushes.at(tick_);
  Vector6d wind_body = Vector6d::Zero();
  if (vehicle.windage && spec_.wind.blows()) loads.body += wind_body = wind_load(vehicle, spec_.wind);
  bodies_.apply(vehicle.body, loads, wind_body);
}

Vector6d Simulation::wind_load(const Vehicle& vehicle, const Wind& wind) const {
  const BodyState& state = bodies_.state(vehicle.body);
  const Windage& windage = *vehicle.windage;
  const BuoyantHull& hull = vehicle.craft->hull();
  const double dry_m3 =
      hull.solid().volume_m3 - hull.submerged_volume_m3(state.world_from_body, world_.water, time_s());
  const Eigen::Vector3d air =
      state.world_from_body.orientation.conjugate() * (windage.speed_share * wind.velocity_m_s(time_s()));
  return windage.load(air - state.linear_body_m_s(), windage.dry_volume_m3 > 0 ? dry_m3 / windage.dry_volume_m3 : 0);
}

Eigen::Vector3d Simulation::station_world_m() const {
  if (!spec_.carried_station) return spec_.station_world_m;
  return state(spec_.carried_station->vehicle).world_from_body.point(spec_.carried_station->position_body_m);
}

/// Moves what is docked with the vehicle that carries the station.
void Simulation::carry_docked() {
  const CarriedStation& station = *spec_.carried_station;
  const BodyState& carrier = state(station.vehicle);
  for (const Vehicle& vehicle : vehicles_) {
    if (vehicle.released()) continue;
    BodyState carried;
    carried.world_from_body = carrier.world_from_body * station.body_from_docked;
    bodies_.set_state(vehicle.body, carried);
  }
}

std::size_t Simulation::body_of(std::size_t object) const {
  if (object < objects()) return vehicles_.size() + object;
  throw std::out_of_range("object = " + std::to_string(object) + ": must be below " + std::to_string(objects()));
}

const Vehicle& Simulation::vehicle(std::size_t index) const { return item(vehicles_, index, "vehicle"); }
Vehicle& Simulation::changeable(std::size_t index) { return item(vehicles_, index, "vehicle"); }

const BodyState& Simulation::state(std::size_t index) const { return bodies_.state(vehicle(index).body); }

VehicleSnapshot Simulation::snapshot(const Vehicle& vehicle) const {
  return {tick_, bodies_.state(vehicle.body), bodies_.acceleration_body(vehicle.body), bodies_.in_contact(vehicle.body),
          station_world_m()};
}

const MovingBodies& Simulation::vehicles_for_rays() const {
  if (hulls_version_ != version_) {
    for (std::size_t k = 0; k < bodies_.size(); ++k) hulls_->place(k, bodies_.state(k).world_from_body);
    std::size_t next = bodies_.size();
    if (hulls_->size() == next) {
      add_link_surfaces(bodies_, *hulls_);
      if (tethers() > 0) hulls_->add_after_schools();
      for (std::size_t k = 0; k < tethers(); ++k) {
        const TetherSpec& spec = bodies_.tether(k).spec();
        const TriangleMesh tube = tether_tube(spec);
        for (std::size_t each = 0; each < spec.tubes(); ++each) hulls_->add(tube);
      }
    }
    attached_.clear();
    add_attached_surfaces(attached_);
    for (const Pose& pose : attached_) hulls_->place(next++, pose);
    hulls_->place_schools(time_s());
    hulls_version_ = version_;
  }
  return *hulls_;
}

RayScene Simulation::scene_around(const Vehicle& vehicle) const {
  const RayScene scene = scene_with_plants();
  if (bodies_.size() < 2 && tethers() == 0 && !hulls_->has_schools() && !has_link_surfaces(bodies_)) return scene;
  vehicles_for_rays();
  return scene.with(hulls_, static_cast<std::size_t>(&vehicle - vehicles_.data()));
}

RayScene Simulation::scene_with_plants() const {
  if (sway_tick_ != tick_) {
    sway_ = Sway::of(world_, time_s());
    sway_tick_ = tick_;
  }
  return sway_ ? scene_->with_plants(sway_) : *scene_;
}

std::vector<Pose> Simulation::link_surfaces() const {
  std::vector<Pose> poses;
  add_link_surface_poses(bodies_, poses);
  return poses;
}

std::vector<Pose> Simulation::attached_surfaces() const {
  std::vector<Pose> poses;
  add_attached_surfaces(poses);
  return poses;
}

void Simulation::add_attached_surfaces(std::vector<Pose>& poses) const {
  add_link_surface_poses(bodies_, poses);
  for (std::size_t k = 0; k < tethers(); ++k) add_tube_poses(bodies_.tether(k), bodies_, poses);
}

RayScene Simulation::scene_around(std::size_t index) const { return scene_around(vehicle(index)); }

const Sample& Simulation::read_sensor(std::size_t index, std::size_t sensor, bool with_noise) {
  Vehicle& reader = changeable(index);
  const Surroundings around{scene_around(reader), world_.water, sound_, &world_};
  NoisySensor& instrument = reader.sensors.at(sensor);
  return with_noise ? instrument.read(snapshot(reader), around) : instrument.read_true(snapshot(reader), around);
}

void Simulation::watch_sensor(std::size_t index, std::size_t sensor, std::optional<std::uint64_t> from_ns) {
  changeable(index).sensors.watch(sensor, from_ns);
}

SampleBatch Simulation::take_samples(std::size_t index, std::size_t sensor) {
  Vehicle& watched = changeable(index);
  watched.sensors.collect(snapshot(watched), {scene_around(watched), world_.water, sound_, &world_});
  return watched.sensors.at(sensor).take_samples();
}

void Simulation::attach(std::shared_ptr<Tape> tape) {
  tape->begin(*this);
  tapes_.push_back(std::move(tape));
}

void Simulation::aim(std::size_t index, std::size_t sonar, double elevation_rad) {
  item(changeable(index).sonars, sonar, "sonar").aim(elevation_rad);
  ++version_;
}

const SonarHead& Simulation::sonar(std::size_t index, std::size_t sonar) const {
  return item(vehicle(index).sonars, sonar, "sonar");
}

Pose Simulation::world_from_sonar(std::size_t index, std::size_t head) const {
  return state(index).world_from_body * sonar(index, head).body_from_sonar();
}

MultibeamPing Simulation::ping(std::size_t index, std::size_t head) const {
  return sonar(index, head).ping(scene_around(index), world_.water, state(index).world_from_body);
}

void Simulation::ping(std::size_t index, std::size_t head, const PingRows& rows) const {
  sonar(index, head).ping(scene_around(index), world_.water, state(index).world_from_body, rows);
}

AcousticPing Simulation::acoustic_ping(std::size_t index, std::size_t head, int threads, bool water_column) const {
  return sonar(index, head).acoustic_ping(scene_around(index), state(index), tick_, threads, {time_s(), water_column});
}

void Simulation::ping_together(std::span<PingOrder* const> orders, int threads) const {
  if (orders.empty()) return;
  static_cast<void>(
      scene_around(orders.front()->vehicle));  // places the bodies for all, so that later calls write nothing
  const int threads_each = orders.size() == 1 ? threads : 1;
  parallel_parts(orders.size(), threads, [&](std::size_t k, std::size_t) {
    PingOrder& order = *orders[k];
    if (sonar(order.vehicle, order.sonar).in_physics_mode())
      order.acoustic = acoustic_ping(order.vehicle, order.sonar, threads_each, order.water_column);
    else
      ping(order.vehicle, order.sonar, order.rows);
  });
}

}  // namespace uwsim
