#include "uwsim/sim/simulation.h"

namespace uwsim {

void Simulation::release(std::size_t index) {
  Vehicle& docked = changeable(index);
  if (docked.released()) return;
  docked.battery.start_mission(tick_);
  bodies_.hold(docked.body, false);
}

void Simulation::dock(std::size_t index, const Pose& world_from_body) {
  Vehicle& free = changeable(index);
  require_free("vehicle '" + free.name + "' dock", world_from_body.position_m);
  bodies_.require_tethers_reach(free.body, world_from_body, world_.water, time_s());
  BodyState held;
  held.world_from_body = world_from_body;
  bodies_.set_state(free.body, held);
  bodies_.hold(free.body, true);
  bodies_.lay_tethers(free.body, world_.water, time_s());
  carry_cargo();
  free.battery.end_mission();
  free.actuators.set_effort(Vector6d::Zero());
  free.touching = false;
  ++version_;
}

}  // namespace uwsim
