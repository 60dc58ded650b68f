#pragma once

#include "uwsim/rays/triangle_hit.h"

namespace uwsim {

/// Whether two triangles are closer to each other than `distance_m`. A triangle without area is treated as its edges.
bool closer_than(const Corners& one, const Corners& other, double distance_m);

}  // namespace uwsim
