#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sim/simulation.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

bool has_same_surfaces(const std::vector<ArmLink>& links, const Arm* arm) {
  if (arm == nullptr || links.size() != arm->size()) return arm == nullptr;  // the latter is refused later
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto &one = links[k].surface_m, &other = arm->links()[k].surface_m;
    if (one != other && (!one || !other || one->vertices_m != other->vertices_m)) return false;
  }
  return true;
}

}  // namespace

/// Builds new vehicles and transfers the state of the present ones to them, as if it had been saved and restored.
/// Everything that may fail is done first.
void Simulation::change(const Water& water, const SimulationSpec& spec, const std::vector<VehicleSpec>& vehicles) {
  spec.check();
  water.check();
  require(spec.step_s == spec_.step_s, "step_s", spec.step_s, "cannot be changed");
  require(spec.seed == spec_.seed, "seed", spec.seed, "cannot be changed");
  require(spec.engine == spec_.engine, "dynamics.engine", spec.engine == EngineKind::kBullet ? "bullet" : "uwsim",
          "cannot be changed");
  require(vehicles.size() == vehicles_.size(), "vehicles", vehicles.size(), "must be one for each");
  std::vector<Vehicle> changed;
  std::vector<BodySpec> bodies;
  bool same_hulls = true;
  for (std::size_t k = 0; k < vehicles.size(); ++k) {
    require(vehicles[k].craft != nullptr, "vehicles.craft", "none", "must be set");
    bodies.push_back(vehicles[k].body());
    require(bodies[k].arm.size() == bodies_.spec(vehicles_[k].body).arm.size(), "arm.links", bodies[k].arm.size(),
            "cannot be changed");
    bodies[k].arm = links_left(k, std::move(bodies[k].arm));
    changed.push_back(equipped(vehicles[k], spec, water));
    changed[k].body = vehicles_[k].body;
    StateArchive present;
    exchange_vehicle(present, vehicles_[k]);
    StateArchive same(present.bytes());
    exchange_vehicle(same, changed[k]);
    Vehicle& before = vehicles_[k];
    before.sensors.settle({scene_around(before), world_.water, sound_, &world_});
    changed[k].sensors.take_over(before.sensors);
    changed[k].actuators.renew_commands();
    changed[k].sensors.watch_like(vehicles_[k].sensors);
    changed[k].pushes.commanded = vehicles_[k].pushes.commanded;
    same_hulls =
        same_hulls &&
        vehicles[k].craft->hull().mesh_body().vertices_m == vehicles_[k].craft->hull().mesh_body().vertices_m &&
        has_same_surfaces(vehicles[k].arm, bodies_.arm(vehicles_[k].body));
  }
  for (std::size_t k = 0; k < objects(); ++k) bodies.push_back(bodies_.spec(body_of(k)));
  std::shared_ptr<MovingBodies> hulls = hulls_;
  if (!same_hulls) {
    hulls = std::make_shared<MovingBodies>(hulls_->label(0), world_.schools());
    for (const BodySpec& body : bodies) hulls->add(body.craft->hull().mesh_body());
  }
  SoundSpeedProfile sound = sound_speed_profile(water);
  std::optional<LinkWater> heard_through;
  if (link_) heard_through.emplace(link_->spec, water);
  bodies_.change_bodies(std::move(bodies));
  if (link_) link_->water = std::move(*heard_through);
  world_.water = water;
  sound_ = std::move(sound);
  spec_ = spec;
  for (LooseObject& one : objects_) {
    if (one.cargo) one.cargo->link = vehicles[one.cargo->carrying.vehicle].arm[one.cargo->carrying.link];
  }
  vehicles_ = std::move(changed);
  if (link_) join_instruments();
  hulls_ = std::move(hulls);
  hulls_version_ = kUnplaced;
  sway_tick_ = kUnplaced;
  ++version_;
}

}  // namespace uwsim
