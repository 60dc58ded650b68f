#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "uwsim/world/space_time_grid.h"

namespace uwsim {

/// A part of an axis between two of its values, beyond its first or beyond its last.
struct AxisPart {
  std::size_t first, second;
  double from, until, per_unit;  ///< per_unit: 0 where values do not change

  AxisPart(const std::vector<double>& axis, double value) {
    const Interval at(axis, value);
    constexpr double kFar = std::numeric_limits<double>::infinity();
    first = at.first;
    second = at.second;
    from = value < axis.front() ? -kFar : axis[first];
    until = value < axis.front() ? axis.front() : first == second ? kFar : axis[second];
    per_unit = first == second ? 0 : 1 / (until - from);
  }
};

/// A cell of a grid, in space and time. Its field is a polynomial of the offset e from its first corner, in units of
/// its edges, with one coefficient for each of 1, e_x, e_y, e_z, e_x e_y, e_y e_z, e_z e_x and e_x e_y e_z. Vectors
/// have a fourth element, 0, for the processor's sake.
struct FieldCell {
  using Terms = std::array<Eigen::Vector4d, 8>;

  std::uint64_t grid = 0;  ///< its number; 0: none
  Eigen::Vector3d low_m, high_m, corner_m, per_m;
  double from_s = 0, until_s = 0, begin_s = 0;
  bool changes = false;
  Terms value, rate;  ///< at begin_s, and per second

  bool holds(std::uint64_t number, const Eigen::Vector3d& p, double time_s) const {
    return grid == number && time_s >= from_s && time_s < until_s && p.x() >= low_m.x() && p.x() < high_m.x() &&
           p.y() >= low_m.y() && p.y() < high_m.y() && p.z() >= low_m.z() && p.z() < high_m.z();
  }
  Eigen::Vector3d offset(const Eigen::Vector3d& p) const { return (p - corner_m).cwiseProduct(per_m); }
  Terms at(double time_s) const {
    if (!changes) return value;
    Terms now;
    for (std::size_t k = 0; k < 8; ++k) now[k] = value[k] + (time_s - begin_s) * rate[k];
    return now;
  }

  static FieldCell of(const SpaceTimeGrid<Eigen::Vector3d>& grid, std::uint64_t number, const Eigen::Vector3d& p,
                      double time_s) {
    const AxisPart x(grid.x_m, p.x()), y(grid.y_m, p.y()), z(grid.z_m, p.z()), t(grid.t_s, time_s);
    const auto start = [](const std::vector<double>& axis, const AxisPart& part) { return axis[part.first]; };
    const std::size_t nx = grid.x_m.size(), nxy = nx * grid.y_m.size(), layer = nxy * grid.z_m.size();
    const auto terms = [&](std::size_t time) {
      const auto corner = [&](std::size_t i, std::size_t j, std::size_t k) -> Eigen::Vector4d {
        const Eigen::Vector3d& v = grid.values[time * layer + k * nxy + j * nx + i];
        return {v.x(), v.y(), v.z(), 0};
      };
      const Eigen::Vector4d v000 = corner(x.first, y.first, z.first), v100 = corner(x.second, y.first, z.first),
                            v010 = corner(x.first, y.second, z.first), v110 = corner(x.second, y.second, z.first),
                            v001 = corner(x.first, y.first, z.second), v101 = corner(x.second, y.first, z.second),
                            v011 = corner(x.first, y.second, z.second), v111 = corner(x.second, y.second, z.second);
      const Eigen::Vector4d dx = v100 - v000, dy = v010 - v000, dz = v001 - v000, xy = v110 - v010 - dx,
                            yz = v011 - v001 - dy, zx = v101 - v001 - dx;
      return Terms{v000, dx, dy, dz, xy, yz, zx, v111 - v011 - (v101 - v001) - xy};
    };
    FieldCell cell;
    cell.grid = number;
    cell.low_m = {x.from, y.from, z.from};
    cell.high_m = {x.until, y.until, z.until};
    cell.corner_m = {start(grid.x_m, x), start(grid.y_m, y), start(grid.z_m, z)};
    cell.per_m = {x.per_unit, y.per_unit, z.per_unit};
    cell.from_s = t.from;
    cell.until_s = t.until;
    cell.begin_s = start(grid.t_s, t);
    cell.changes = t.per_unit > 0;
    cell.value = cell.rate = terms(t.first);
    if (!cell.changes) return cell;
    const Terms after = terms(t.second);
    for (std::size_t k = 0; k < 8; ++k) cell.rate[k] = t.per_unit * (after[k] - cell.value[k]);
    return cell;
  }
};

/// The cells that a thread used most recently, of any grid: those about one position, whose number is at most eight.
class RememberedCells {
 public:
  static RememberedCells& of_this_thread() {
    static thread_local RememberedCells cells;
    return cells;
  }

  const FieldCell& find(const SpaceTimeGrid<Eigen::Vector3d>& grid, std::uint64_t number, const Eigen::Vector3d& p,
                        double time_s) {
    if (cells_[last_].holds(number, p, time_s)) return cells_[last_];
    for (std::size_t k = 0; k < cells_.size(); ++k) {
      if (cells_[k].holds(number, p, time_s)) return cells_[last_ = k];
    }
    last_ = oldest_;
    oldest_ = (oldest_ + 1) % cells_.size();
    return cells_[last_] = FieldCell::of(grid, number, p, time_s);
  }

 private:
  std::array<FieldCell, 8> cells_;
  std::size_t last_ = 0, oldest_ = 0;
};

}  // namespace uwsim
