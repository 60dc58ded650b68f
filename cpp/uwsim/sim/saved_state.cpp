#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sim/saved_state_format.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kLastNs = std::numeric_limits<std::int64_t>::max();

}  // namespace

std::string Simulation::save_state(const StateOrigin& origin, const std::string& notes) {
  StateArchive archive;
  std::string kept = notes;
  archive(kept);
  exchange_state(archive);
  return wrapped_state(archive.bytes(), origin);
}

std::string Simulation::restore_state(std::string_view bytes, const StateOrigin& origin) {
  StateArchive archive(unwrapped_state(bytes, origin));
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

std::string saved_notes(std::string_view bytes, const StateOrigin& origin) {
  StateArchive archive(unwrapped_state(bytes, origin));
  std::string notes;
  archive(notes);
  return notes;
}

void Simulation::exchange_state(StateArchive& archive) {
  archive.same("step_ns", step_ns_);
  archive.same("seed", spec_.seed);
  archive(tick_);
  require(tick_ <= kLastNs / step_ns_, "state.tick", tick_, "must be a time that nanoseconds can count");
  archive.same("vehicles", vehicles_.size());
  for (Vehicle& vehicle : vehicles_) exchange_vehicle(archive, vehicle);
  exchange_cargo(archive);
  bodies_.exchange_state(archive);
  std::uint64_t layout = link_ ? PacketNetwork::kLayout : 0;
  archive(layout);
  require((layout > 0) == link_.has_value(), "state.link", layout, link_ ? "must be of a link" : "must be 0: no link");
  if (link_) {
    require(layout == PacketNetwork::kLayout, "state.link.version", layout,
            "must be " + std::to_string(PacketNetwork::kLayout) + ": another version of uwsim saved it");
    link_->network.exchange_state(archive);
    for (PositionExchange& one : link_->exchanges) one.exchange_state(archive, link_->network, tick_);
  }
  bodies_.exchange_contacts(archive);
  exchange_applied(archive);
  exchange_details(archive);
}

/// The wrenches that act on the bodies, the last step, and what is attached to bodies.
void Simulation::exchange_applied(StateArchive& archive) {
  for (Vehicle& vehicle : vehicles_) vehicle.pushes.exchange_state(archive);
  bodies_.exchange_last_step(archive);
  if (spec_.wind.blows()) bodies_.exchange_wind(archive);
  bodies_.exchange_tethers(archive);
  bodies_.exchange_arms(archive);
  for (LooseObject& one : objects_) one.pushes.exchange_state(archive);
}

/// The details of samples: what an instrument's readings depend on besides the vehicle's state.
void Simulation::exchange_details(StateArchive& archive) {
  for (Vehicle& vehicle : vehicles_) vehicle.sensors.exchange_details(archive);
  if (!link_) return;
  for (PositionExchange& one : link_->exchanges) one.exchange_station(archive);
}

void Simulation::exchange_vehicle(StateArchive& archive, Vehicle& vehicle) const {
  archive.same("vehicle", vehicle.name);
  vehicle.battery.exchange_state(archive, tick_);
  archive(vehicle.touching);
  archive(vehicle.collisions);
  vehicle.actuators.exchange_state(archive);
  vehicle.sensors.exchange_state(archive, tick_);
  archive.same("sonars", vehicle.sonars.size());
  for (SonarHead& sonar : vehicle.sonars) sonar.exchange_state(archive);
}

}  // namespace uwsim
