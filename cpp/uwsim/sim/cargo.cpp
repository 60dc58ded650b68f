#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sim/simulation.h"

// Loose bodies that vehicles carry until they are released. While one is loaded, its mass, its buoyancy and its water
// are those of a link that is fixed to the vehicle, and the body itself, held, only shows where it is.
namespace uwsim {
namespace {

constexpr double kGone = 1e-12;  // share of a link that is left when its body is gone: a link must have a mass

ArmLink gone(ArmLink link) {
  link.mass_kg *= kGone;
  link.inertia_kg_m2 *= kGone;
  link.volume_m3 *= kGone;
  link.added_mass *= kGone;
  link.linear_drag *= kGone;
  link.quadratic_drag *= kGone;
  return link;
}

}  // namespace

Cargo& Simulation::cargo_of(std::size_t object) {
  const std::string& name = body_name(body_of(object));
  require(objects_[object].cargo.has_value(), "object", name, "must be one that a vehicle carries");
  return *objects_[object].cargo;
}

bool Simulation::object_loaded(std::size_t object) const {
  const std::optional<Cargo>& cargo = objects_.at(object).cargo;
  return cargo && cargo->loaded;
}

void Simulation::add_cargo(std::size_t object, const Carrying& carrying) {
  const std::vector<ArmLink>& links = bodies_.spec(vehicle(carrying.vehicle).body).arm;
  require(carrying.link < links.size(), "carrying.link", carrying.link, "must be a link of the vehicle");
  require(std::abs(carrying.along_body.norm() - 1) < 1e-6, "carrying.along_body", carrying.along_body.transpose(),
          "must be a unit vector");
  require(carrying.spring_j >= 0, "carrying.spring_j", carrying.spring_j, "J: must not be negative");
  objects_[object].cargo = Cargo{carrying, links[carrying.link]};
  bodies_.hold(body_of(object), true);
  bodies_.carry(body_of(object), carried_state(carrying));
}

/// The state that a body has where its vehicle carries it.
BodyState Simulation::carried_state(const Carrying& carrying) const {
  const BodyState& carrier = state(carrying.vehicle);
  const Pose& at = carrying.body_from_object;
  const Eigen::Vector3d turn = carrier.angular_body_rad_s();
  const Eigen::Quaterniond object_from_body = at.orientation.conjugate();
  BodyState carried;
  carried.world_from_body = carrier.world_from_body * at;
  carried.velocity_body << object_from_body * (carrier.linear_body_m_s() + turn.cross(at.position_m)),
      object_from_body * turn;
  return carried;
}

void Simulation::carry_cargo() {
  for (std::size_t k = 0; k < objects_.size(); ++k) {
    if (object_loaded(k)) bodies_.carry(body_of(k), carried_state(objects_[k].cargo->carrying));
  }
}

/// The links of a vehicle without what it has released.
std::vector<ArmLink> Simulation::links_left(std::size_t vehicle, std::vector<ArmLink> links) const {
  for (const LooseObject& one : objects_) {
    if (!one.cargo || one.cargo->carrying.vehicle != vehicle || one.cargo->loaded) continue;
    ArmLink& link = links.at(one.cargo->carrying.link);
    link = gone(link);
  }
  return links;
}

void Simulation::set_loaded(std::size_t object, bool loaded) {
  Cargo& cargo = cargo_of(object);
  const std::size_t body = vehicle(cargo.carrying.vehicle).body;
  std::vector<ArmLink> links = bodies_.spec(body).arm;
  links.at(cargo.carrying.link) = loaded ? cargo.link : gone(cargo.link);
  bodies_.change_links(body, std::move(links));
  bodies_.hold(body_of(object), loaded);
  cargo.loaded = loaded;
}

void Simulation::release_object(std::size_t object) {
  const Cargo& cargo = cargo_of(object);
  require(cargo.loaded, "object '" + body_name(body_of(object)) + "'", "released", "must be loaded");
  set_loaded(object, false);
  bodies_.set_state(body_of(object), carried_state(cargo.carrying));
  if (cargo.carrying.spring_j > 0) spring_apart(object);
  ++version_;
}

void Simulation::load_object(std::size_t object) {
  require(!cargo_of(object).loaded, "object '" + body_name(body_of(object)) + "'", "loaded", "must have been released");
  set_loaded(object, true);
  carry_cargo();
  ++version_;
}

/// Through the object's origin, with the mobilities k of both there: the impulse J sets them apart at J (k_o + k_v),
/// and its work is J^2 (k_o + k_v) / 2.
void Simulation::spring_apart(std::size_t index) {
  const Carrying& carrying = cargo_of(index).carrying;
  const std::size_t object = body_of(index), carrier = vehicle(carrying.vehicle).body;
  const Pose& at = carrying.body_from_object;
  Vector6d on_carrier, on_object;
  on_carrier << carrying.along_body, at.position_m.cross(carrying.along_body);
  on_object << at.orientation.conjugate() * carrying.along_body, Eigen::Vector3d::Zero();
  const Vector6d carrier_rate = bodies_.inverse_mass(carrier, world_.water, time_s()) * on_carrier;
  const Vector6d object_rate = bodies_.inverse_mass(object, world_.water, time_s()) * on_object;
  const double mobility = on_carrier.dot(carrier_rate) + on_object.dot(object_rate);
  const double impulse = std::sqrt(2 * carrying.spring_j / mobility);
  BodyState shot = bodies_.state(object), recoiled = bodies_.state(carrier);
  shot.velocity_body += impulse * object_rate;
  recoiled.velocity_body -= impulse * carrier_rate;
  bodies_.set_state(object, shot);
  if (!bodies_.held(carrier)) bodies_.set_state(carrier, recoiled);
}

/// Before the bodies, whose last step is restored after it.
void Simulation::exchange_cargo(StateArchive& archive) {
  for (std::size_t k = 0; k < objects_.size(); ++k) {
    if (!objects_[k].cargo) continue;
    bool loaded = objects_[k].cargo->loaded;
    archive(loaded);
    if (loaded != objects_[k].cargo->loaded) set_loaded(k, loaded);
  }
}

}  // namespace uwsim
