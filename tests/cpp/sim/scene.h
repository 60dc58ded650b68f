#pragma once

#include <vector>

#include "uwsim/sim/simulation.h"

namespace uwsim {

inline constexpr double kBed_m = -20;
inline const StateOrigin kHere{"a scenario", "a build"};

inline World flat_world() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, kBed_m), 2, 2, 400.0, {-200, -200}));
  return world;
}

}  // namespace uwsim
