#pragma once

#include <Eigen/Core>

namespace uwsim {

/// Minimises 1/2 weight |x|^2 - gain . x over the polytope `normals` x <= `limits`, starting from a feasible point `x`:
/// a quadratic programme (weight 1) or a linear one (weight 0, bounded polytopes only). Uses a primal active-set method
/// (Nocedal and Wright 2006, "Numerical Optimization", alg. 16.3), suited to the few unknowns of a thruster allocation.
Eigen::VectorXd minimise_in_polytope(double weight, const Eigen::VectorXd& gain, const Eigen::MatrixXd& normals,
                                     const Eigen::VectorXd& limits, Eigen::VectorXd x);

}  // namespace uwsim
