#include "uwsim/core/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace uwsim {

Matrix6d inverse_of_positive(const Matrix6d& matrix) { return matrix.llt().solve(Matrix6d::Identity()); }

Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector6d eigenvalues(const Matrix6d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Modes<3> principal_axes(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Modes<6> modes(const Matrix6d& a, const Matrix6d& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> solver(a, b);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace uwsim
