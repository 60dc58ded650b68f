#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace uwsim {

/// The two adjacent grid values of an axis that enclose a value, and the value's fractional position between them.
/// Values beyond the ends are moved to the end.
struct Interval {
  std::size_t first = 0, second = 0;
  double fraction = 0;

  Interval(const std::vector<double>& axis, double value) {
    const auto next = static_cast<std::size_t>(std::upper_bound(axis.begin(), axis.end(), value) - axis.begin());
    first = next == 0 ? 0 : next - 1;
    second = std::min(next, axis.size() - 1);
    if (first != second) fraction = (value - axis[first]) / (axis[second] - axis[first]);
  }
};

/// Values on a grid of positions and times, linear between its points along each axis and constant beyond the edges.
/// The value at (t[l], x[i], y[j], z[k]) has the index ((l * nz + k) * ny + j) * nx + i.
template <typename Value>
struct SpaceTimeGrid {
  std::vector<double> x_m, y_m, z_m;  ///< rising; z points up
  std::vector<double> t_s{0};         ///< rising
  std::vector<Value> values;

  std::size_t size() const { return t_s.size() * layer_size(); }

  Value at(const Eigen::Vector3d& p, double time_s) const {
    const Interval x(x_m, p.x()), y(y_m, p.y()), z(z_m, p.z());
    if (t_s.size() == 1) return in(0, x, y, z);
    const Interval t(t_s, time_s);
    const Value before = in(t.first, x, y, z);
    return before + t.fraction * (in(t.second, x, y, z) - before);
  }

 private:
  std::size_t layer_size() const { return x_m.size() * y_m.size() * z_m.size(); }
  Value in(std::size_t layer, const Interval& x, const Interval& y, const Interval& z) const {
    const auto row = [&](std::size_t j, std::size_t k) -> Value {
      const Value* v = &values[layer * layer_size() + (k * y_m.size() + j) * x_m.size()];
      return v[x.first] + x.fraction * (v[x.second] - v[x.first]);
    };
    const auto plane = [&](std::size_t k) -> Value {
      const Value near = row(y.first, k);
      return near + y.fraction * (row(y.second, k) - near);
    };
    const Value low = plane(z.first);
    return low + z.fraction * (plane(z.second) - low);
  }
};

}  // namespace uwsim
