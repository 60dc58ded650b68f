#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/sim/simulation.h"

// Wrenches that act on vehicles from outside, and the forces on them.
namespace uwsim {
namespace {

constexpr double kForever = 1e18;  // steps

}  // namespace

void Simulation::apply_wrench(std::size_t index, const Vector6d& wrench, bool in_world_axes, double duration_s) {
  Vehicle& pushed = changeable(index);
  require(wrench.allFinite() && wrench.cwiseAbs().maxCoeff() <= AppliedWrench::kLargest,
          "vehicle '" + pushed.name + "' wrench", wrench.transpose(), "must be at most 1e9 N and N m");
  require(duration_s >= 0, "duration_s", duration_s, "must not be negative");
  const double steps = duration_s > 0 ? std::clamp(std::round(duration_s / spec_.step_s), 1.0, kForever) : 0;
  pushed.commanded = {wrench, in_world_axes, tick_, tick_ + static_cast<std::uint64_t>(steps)};
}

Loads Simulation::applied(const Vehicle& vehicle) const {
  Loads all;
  const auto add = [&](const AppliedWrench& one) {
    if (tick_ < one.from_tick || tick_ >= one.until_tick) return;
    (one.in_world_axes ? all.world : all.body) += one.wrench;
  };
  add(vehicle.commanded);
  for (const AppliedWrench& one : vehicle.scheduled) add(one);
  return all;
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

}  // namespace uwsim
