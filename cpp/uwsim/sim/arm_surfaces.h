#pragma once

#include <cstddef>
#include <vector>

#include "uwsim/dynamics/rigid_body_world.h"
#include "uwsim/rays/moving_bodies.h"

namespace uwsim {

/// Adds where the links are that have a surface: of all bodies in order, in the links' order.
void add_link_surface_poses(const RigidBodyWorld& bodies, std::vector<Pose>& poses);

/// Returns true if any link has a surface.
bool has_link_surfaces(const RigidBodyWorld& bodies);

/// Adds the surfaces of all links as targets for rays, in the same order.
void add_link_surfaces(const RigidBodyWorld& bodies, MovingBodies& targets);

}  // namespace uwsim
