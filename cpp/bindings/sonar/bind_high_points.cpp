#include <pybind11/stl.h>

#include <optional>
#include <tuple>

#include "bindings/core/points.h"
#include "bindings/sonar/binders.h"
#include "uwsim/sonar/high_points.h"

namespace uwsim::bindings {
namespace {

using Point = std::tuple<double, double, double>;

Eigen::Matrix4d as_transform(const py::object& object) {
  const auto matrix = as_array<double>(object, "world_from_points", {4, 4});
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data());
}

/// Calls work(points). float32 points are passed without a copy; any others are converted to float64.
template <typename Work>
auto with_points(const py::object& points_m, const Work& work) {
  if (py::isinstance<py::array_t<float>>(points_m)) {
    const auto points = as_array<float>(points_m, "points_m", {-1, 3});
    return work(span_of(points));
  }
  const auto points = as_array<double>(points_m, "points_m", {-1, 3});
  return work(span_of(points));
}

std::optional<Point> highest(const py::object& points_m, const py::object& world_from_points,
                             const py::object& position_world_m, double heading_rad, double half_width_m,
                             double ahead_m) {
  const Eigen::Matrix4d transform = as_transform(world_from_points);
  const Corridor corridor(as_vector3(position_world_m, "position_world_m"), heading_rad, half_width_m, ahead_m);
  const auto found =
      with_points(points_m, [&](const auto& points) { return highest_in_corridor(points, transform, corridor); });
  return found ? std::optional(Point{found->x(), found->y(), found->z()}) : std::nullopt;
}

}  // namespace

void bind_high_points(py::module_& m) {
  m.def("highest_in_corridor", &highest, py::arg("points_m"), py::arg("world_from_points"), py::arg("position_world_m"),
        py::arg("heading_rad"), py::arg("half_width_m"), py::arg("ahead_m"),
        "Return x, y, z in the world of the highest point in the corridor from half_width_m behind a position\n"
        "to ahead_m in front of it, half_width_m to either side of the heading; None if there is none.\n"
        "points_m: (n, 3); points with NaN are ignored. world_from_points: (4, 4). position_world_m: (3,).\n"
        "Raises ValueError.");
  m.def(
      "points_above",
      [](const py::object& points_m, const py::object& world_from_points, double z_world_m) {
        const Eigen::Matrix4d transform = as_transform(world_from_points);
        return rows_out(
            with_points(points_m, [&](const auto& points) { return points_above(points, transform, z_world_m); }));
      },
      py::arg("points_m"), py::arg("world_from_points"), py::arg("z_world_m"),
      "Return the points that are higher than z_world_m, (k, 3) float64, world frame, in their original\n"
      "order. points_m: (n, 3); points with NaN are ignored. world_from_points: (4, 4). Raises ValueError.");
}

}  // namespace uwsim::bindings
