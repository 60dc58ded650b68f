#pragma once

#include "uwsim/rays/triangle_hit.h"

namespace uwsim {

/// Whether two triangles come closer to each other than that. Without area they count as their edges.
bool closer_than(const Corners& one, const Corners& other, double distance_m);

}  // namespace uwsim
