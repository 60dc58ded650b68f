#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

namespace uwsim {

/// A symmetric, positive definite matrix of 3 x 3 blocks, in which row i has blocks in columns i, i + 1 and i + 2;
/// those of i + 2 are multiples of the identity. Its direct solution takes time in proportion to its rows.
struct BlockBand {
  std::vector<Eigen::Matrix3d> diagonal, next;
  std::vector<double> second;

  void resize(std::size_t rows) {
    diagonal.resize(rows);
    next.resize(rows);
    second.resize(rows);
  }

  /// Replaces `x` by the solution of A y = x for the first `rows` rows, and the matrix by its factors.
  void solve(std::size_t rows, std::vector<Eigen::Vector3d>& x) {
    for (std::size_t i = 0; i < rows; ++i) {
      const Eigen::Matrix3d inverse = diagonal[i].inverse();
      diagonal[i] = inverse;
      if (i + 1 >= rows) break;
      const Eigen::Matrix3d part = inverse * next[i];
      diagonal[i + 1].noalias() -= next[i].transpose() * part;
      x[i + 1].noalias() -= part.transpose() * x[i];
      if (i + 2 >= rows || second[i] == 0) continue;
      next[i + 1] -= second[i] * part.transpose();
      diagonal[i + 2] -= second[i] * second[i] * inverse;
      x[i + 2] -= second[i] * (inverse * x[i]);
    }
    for (std::size_t i = rows; i-- > 0;) {
      Eigen::Vector3d known = x[i];
      if (i + 1 < rows) known.noalias() -= next[i] * x[i + 1];
      if (i + 2 < rows) known -= second[i] * x[i + 2];
      x[i] = diagonal[i] * known;
    }
  }
};

}  // namespace uwsim
