#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace uwsim {

/// y at x on the polyline through (xs, ys), constant beyond its ends. The xs never decrease; of equal xs, the first is
/// used.
inline double interpolated(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  const auto next = static_cast<std::size_t>(std::lower_bound(xs.begin(), xs.end(), x) - xs.begin());
  if (next == 0) return ys.front();
  if (next == xs.size()) return ys.back();
  const double fraction = (x - xs[next - 1]) / (xs[next] - xs[next - 1]);
  return ys[next - 1] + fraction * (ys[next] - ys[next - 1]);
}

}  // namespace uwsim
