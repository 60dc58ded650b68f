#pragma once

#include <cstddef>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// Returns the same surface with edges split until it has `panels` triangles or one more. The longest edges come first,
/// in a metric that stretches what lies across a convex edge of the body, where the flow's speed is infinite: with
/// layers whose distances from it grow as cubes, a potential that is linear on each triangle converges as on a smooth
/// body (von Petersdorff and Stephan 1990, Math. Methods Appl. Sci. 12). Throws InvalidValue unless the mesh is closed.
TriangleMesh refined(const TriangleMesh& mesh, std::size_t panels);

}  // namespace uwsim
