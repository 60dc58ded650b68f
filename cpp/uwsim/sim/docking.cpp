#include "uwsim/sim/simulation.h"

namespace uwsim {

void Simulation::release(std::size_t index) {
  Vehicle& docked = changeable(index);
  if (docked.released()) return;
  docked.battery.start_mission(tick_);
  bodies_.hold(docked.body, false);
}

}  // namespace uwsim
