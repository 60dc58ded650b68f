#pragma once

#include <vector>

#include "uwsim/dynamics/rigid_body_world.h"

namespace uwsim {

/// A closed hexagonal tube as long as an element, along z from the origin: TetherSpec::tubes() of them are what light
/// and sound meet of a tether.
TriangleMesh tether_tube(const TetherSpec& spec);

/// Adds where the tubes lie to `poses`: along the tether's elements, two along the first, whose length varies. Those
/// without an element, and those within the sphere around a body at one of its ends, through whose hull it
/// may pass, lie where others do.
void add_tube_poses(const Tether& tether, const RigidBodyWorld& bodies, std::vector<Pose>& poses);

}  // namespace uwsim
