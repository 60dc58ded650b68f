#include "uwsim/dynamics/block_band.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace uwsim {

void BlockBand::factor(std::size_t rows) {
  for (std::size_t i = 0; i < rows; ++i) {
    const Eigen::Matrix3d inverse = diagonal[i].inverse();
    diagonal[i] = inverse;
    if (i + 1 >= rows) break;
    const Eigen::Matrix3d beside = next[i];
    next[i].noalias() = inverse * beside;
    diagonal[i + 1].noalias() -= beside.transpose() * next[i];
    if (i + 2 >= rows || second[i] == 0) continue;
    next[i + 1] -= second[i] * next[i].transpose();
    diagonal[i + 2] -= second[i] * second[i] * inverse;
  }
}

void BlockBand::solve(std::size_t rows, std::vector<Eigen::Vector3d>& x) const {
  for (std::size_t i = 0; i + 1 < rows; ++i) {
    x[i + 1].noalias() -= next[i].transpose() * x[i];
    x[i] = diagonal[i] * x[i];
    if (i + 2 < rows) x[i + 2] -= second[i] * x[i];
  }
  x[rows - 1] = diagonal[rows - 1] * x[rows - 1];
  for (std::size_t i = rows - 1; i-- > 0;) {
    if (i + 2 < rows) x[i].noalias() -= second[i] * (diagonal[i] * x[i + 2]);
    x[i].noalias() -= next[i] * x[i + 1];
  }
}

void BlockBand::factor_stiff(std::size_t rows) {
  for (std::size_t i = 0; i < rows; ++i) {
    diagonal[i] = Eigen::LLT<Eigen::Matrix3d>(diagonal[i]).matrixL();
    const auto lower = diagonal[i].triangularView<Eigen::Lower>();
    if (i + 1 >= rows) break;
    lower.solveInPlace(next[i]);
    diagonal[i + 1].noalias() -= next[i].transpose() * next[i];
    if (i + 2 >= rows || second[i] == 0) continue;
    const Eigen::Matrix3d two = lower.solve(Eigen::Matrix3d(second[i] * Eigen::Matrix3d::Identity()));
    next[i + 1].noalias() -= next[i].transpose() * two;
    diagonal[i + 2].noalias() -= two.transpose() * two;
  }
}

void BlockBand::solve_stiff(std::size_t rows, std::vector<Eigen::Vector3d>& x) const {
  for (std::size_t i = 0; i < rows; ++i) {
    diagonal[i].triangularView<Eigen::Lower>().solveInPlace(x[i]);
    if (i + 1 < rows) x[i + 1].noalias() -= next[i].transpose() * x[i];
    if (i + 2 < rows && second[i] != 0)
      x[i + 2] -= second[i] * diagonal[i].transpose().triangularView<Eigen::Upper>().solve(x[i]);
  }
  for (std::size_t i = rows; i-- > 0;) {
    const auto lower = diagonal[i].triangularView<Eigen::Lower>();
    if (i + 1 < rows) x[i].noalias() -= next[i] * x[i + 1];
    if (i + 2 < rows && second[i] != 0) x[i] -= lower.solve(Eigen::Vector3d(second[i] * x[i + 2]));
    diagonal[i].transpose().triangularView<Eigen::Upper>().solveInPlace(x[i]);
  }
}

}  // namespace uwsim
