#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/sim/simulation.h"

// Wrenches that act on bodies from outside, and the forces on them.
namespace uwsim {
namespace {

constexpr double kForever = 1e18;  // steps

}  // namespace

void Pushes::command(const std::string& body, const Vector6d& wrench, bool in_world_axes, std::uint64_t tick,
                     double duration_s, double step_s) {
  require(wrench.allFinite() && wrench.cwiseAbs().maxCoeff() <= AppliedWrench::kLargest, body + " wrench",
          wrench.transpose(), "must be at most 1e9 N and N m");
  require(duration_s >= 0, "duration_s", duration_s, "must not be negative");
  const double steps = duration_s > 0 ? std::clamp(std::round(duration_s / step_s), 1.0, kForever) : 0;
  commanded = {wrench, in_world_axes, tick, tick + static_cast<std::uint64_t>(steps)};
}

Loads Pushes::at(std::uint64_t tick) const {
  Loads all;
  const auto add = [&](const AppliedWrench& one) {
    if (tick < one.from_tick || tick >= one.until_tick) return;
    (one.in_world_axes ? all.world : all.body) += one.wrench;
  };
  add(commanded);
  for (const AppliedWrench& one : scheduled) add(one);
  return all;
}

void Pushes::exchange_state(StateArchive& archive) {
  archive(commanded.wrench);
  archive(commanded.in_world_axes);
  archive(commanded.from_tick);
  archive(commanded.until_tick);
  require(commanded.wrench.allFinite() && commanded.wrench.cwiseAbs().maxCoeff() <= AppliedWrench::kLargest,
          "state.wrench", commanded.wrench.transpose(), "must be at most 1e9 N and N m");
}

void Simulation::apply_wrench(std::size_t index, const Vector6d& wrench, bool in_world_axes, double duration_s) {
  Vehicle& pushed = changeable(index);
  pushed.pushes.command("vehicle '" + pushed.name + "'", wrench, in_world_axes, tick_, duration_s, spec_.step_s);
}

void Simulation::apply_object_wrench(std::size_t object, const Vector6d& wrench, bool in_world_axes,
                                     double duration_s) {
  const std::string name = "object '" + body_name(body_of(object)) + "'";
  require(!bodies_.spec(body_of(object)).path, name + " wrench", wrench.transpose(),
          "must not be for a body on a path");
  objects_.at(object).pushes.command(name, wrench, in_world_axes, tick_, duration_s, spec_.step_s);
}

Arm& Simulation::arm(std::size_t body) {
  Arm* const arm = bodies_.arm(body);
  require(arm != nullptr, "body '" + body_name(body) + "' arm", "none", "must be in the vehicle's file");
  return *arm;
}

std::string Simulation::link_name(std::size_t body, std::uint64_t link) const {
  return link == Touch::kNoLink ? "" : bodies_.spec(body).arm.at(link).name;
}

Forces Simulation::forces(std::size_t index) const {
  return bodies_.forces(vehicle(index).body, world_.water, time_s());
}

const std::vector<Touch>& Simulation::touches(std::size_t index) const { return bodies_.touches(vehicle(index).body); }

Forces Simulation::object_forces(std::size_t object) const {
  return bodies_.forces(body_of(object), world_.water, time_s());
}

const std::vector<Touch>& Simulation::object_touches(std::size_t object) const {
  return bodies_.touches(body_of(object));
}

WetSurface Simulation::wet_surface(std::size_t index) const {
  const Pose& pose = state(index).world_from_body;
  return vehicle(index).craft->hull().wet_surface(pose.position_m, pose.rotation(), world_.water, time_s());
}

WetSurface Simulation::object_wet_surface(std::size_t object) const {
  const Pose& pose = object_state(object).world_from_body;
  const BuoyantHull& hull = bodies_.spec(body_of(object)).craft->hull();
  return hull.wet_surface(pose.position_m, pose.rotation(), world_.water, time_s());
}

}  // namespace uwsim
