#pragma once

#include <Eigen/Core>

#include "uwsim/core/body_state.h"

namespace uwsim {

// Eigen's decompositions of symmetric matrices, compiled in one file: their templates take seconds in each that has
// them.

/// The inverse of a positive definite matrix, by its Cholesky factors.
Matrix6d inverse_of_positive(const Matrix6d& matrix);

/// Ascending.
Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& symmetric);
Vector6d eigenvalues(const Matrix6d& symmetric);

/// Values ascend; vectors are columns.
template <int Size>
struct Modes {
  Eigen::Matrix<double, Size, 1> values;
  Eigen::Matrix<double, Size, Size> vectors;
};

/// Unit vectors along the axes of a symmetric matrix.
Modes<3> principal_axes(const Eigen::Matrix3d& symmetric);

/// A v = value B v and v . B v = 1, for a positive definite B.
Modes<6> modes(const Matrix6d& a, const Matrix6d& b);

}  // namespace uwsim
