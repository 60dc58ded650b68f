#pragma once

#include "uwsim/rays/triangle_hit.h"

namespace uwsim {

/// The triangle with each edge moved outward in its plane by `widening_m`, or by more if a corner is sharper than 14
/// degrees. Solids' triangles are passed to Embree in this form, so that float's error does not make a ray miss them.
Corners widened(const Corners& triangle, double widening_m);

/// A point of the widened triangle whose three barycentric coordinates there are all larger than this is on the
/// triangle itself, by more than float's error. 1, which no point has, where there is no such point.
float margin_within(const Corners& wide, const Corners& triangle);

}  // namespace uwsim
