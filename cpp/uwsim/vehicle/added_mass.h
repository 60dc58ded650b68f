#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// The added mass of a closed hull about its origin [kg, kg m, kg m^2], in ideal flow far from surface and bed, without
/// separation (Newman 1977, "Marine Hydrodynamics", sec. 4.13), by a boundary-element method: its triangles are the
/// panels.
///
/// With the normal velocities v of a unit motion, the potential on the hull is u = -V v - (1/2 + K) W^-1 (1/2 + K') v,
/// where V, K, K', W are the boundary integral operators of 1/(4 pi r) (Steinbach 2008, "Numerical Approximation
/// Methods for Elliptic Boundary Value Problems", sec. 6.6), and the added mass is -rho <v, u>. Galerkin's method with
/// potentials that are linear on each triangle makes it symmetric, positive and, apart from quadrature, a lower bound:
/// it grows as panels are halved. The result does not depend on `threads`. Throws InvalidValue.
Matrix6d added_mass(const TriangleMesh& closed, double density_kg_m3, int threads);

}  // namespace uwsim
