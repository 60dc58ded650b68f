#include "uwsim/estimation/aid.h"

namespace uwsim {

bool Aid::correct(FilterState& state, double residual, const ErrorVector& h, double variance) const {
  ErrorMatrix& p = state.covariance;
  AidCounts& counts = state.counts[static_cast<std::size_t>(index)];
  ErrorVector seen_by = p * h;
  double expected = h.dot(seen_by) + variance;
  if (residual * residual > kGate * kGate * expected) {
    ++counts.rejected;
    if (counts.in_a_row + 1 < kReadingsBeforeDoubt) return false;
    for (int k = seen(); k < seen() + 3; ++k) p(k, k) += residual * residual;
    ++state.doubts;
    seen_by = p * h;
    expected = h.dot(seen_by) + variance;
  } else {
    ++counts.accepted;
  }
  const ErrorVector gain = seen_by / expected;
  state.add(gain * residual);
  // The Joseph form, (I - K h) P (I - K h)^T + K R K^T, computed as two rank-one updates.
  p.noalias() -= gain * seen_by.transpose();
  const ErrorVector left = p * h;
  p.noalias() += (variance * gain - left) * gain.transpose();
  p = (0.5 * (p + p.transpose())).eval();
  return true;
}

}  // namespace uwsim
