#pragma once

#include <Eigen/Core>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The boundary of the part of a solid between two planes at right angles to a coordinate axis. The cut faces are fans
/// of triangles from one point, some of which may overlap with opposite orientations: integrals over the boundary, or
/// over the volume inside it, are exact, even for solids that are not convex. Vertices are not shared.
TriangleMesh slice_between(const TriangleMesh& mesh, Eigen::Index axis, double low_m, double high_m);

}  // namespace uwsim
