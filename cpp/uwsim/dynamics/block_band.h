#pragma once

#include <Eigen/Core>
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

  /// Replaces the matrix of the first `rows` rows by its factors: the inverses of the pivots, and these times the
  /// blocks beside them, so that solve() waits for one product from row to row.
  void factor(std::size_t rows);
  /// Replaces `x` by the solution of A y = x, after factor().
  void solve(std::size_t rows, std::vector<Eigen::Vector3d>& x) const;
  /// Both by Cholesky's factors (Golub and Van Loan 2013, "Matrix Computations", 4.3), where a block may be far
  /// stiffer in one direction than in another: if by a ratio r, the error of its inverse by cofactors is of the order
  /// of r^3 times that of a number.
  void factor_stiff(std::size_t rows);
  void solve_stiff(std::size_t rows, std::vector<Eigen::Vector3d>& x) const;
};

}  // namespace uwsim
