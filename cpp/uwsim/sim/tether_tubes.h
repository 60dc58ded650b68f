#pragma once

#include "uwsim/dynamics/rigid_body_world.h"
#include "uwsim/rays/moving_bodies.h"

namespace uwsim {

/// Adds a tether as targets for rays, TetherSpec::tubes() hexagonal tubes as long as an element.
void add_tubes(const TetherSpec& spec, MovingBodies& targets);

/// Lays the tubes from the index `first` on along the tether's elements, two along the first, whose length varies.
/// Those without an element, and those within the sphere around the vehicle at the tether's second end, through whose
/// hull it may pass, lie where others do. Returns the index after the last.
std::size_t place_tubes(const Tether& tether, const RigidBodyWorld& bodies, std::size_t first, MovingBodies& targets);

}  // namespace uwsim
