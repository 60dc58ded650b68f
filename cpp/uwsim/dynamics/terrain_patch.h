#pragma once

#include <Eigen/Core>

#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/surface_patch.h"
#include "uwsim/world/heightfield.h"

namespace uwsim {

/// Adds to `patch` the terrain cells that a box stands on or reaches into: those below, inside and above it. Throws
/// ContactBudgetExceeded.
void add_terrain(const Heightfield& terrain, const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                 SurfacePatch& patch, ContactBudget& budget);

}  // namespace uwsim
