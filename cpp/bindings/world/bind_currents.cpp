#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/world/binders.h"
#include "uwsim/world/current.h"

namespace uwsim::bindings {
namespace {

/// velocity_m_s: (nz, ny, nx, 3), or (nt, nz, ny, nx, 3) with t_s.
std::shared_ptr<const Current> gridded(const py::object& x_m, const py::object& y_m, const py::object& z_m,
                                       const py::object& velocity_m_s, const py::object& t_s) {
  CurrentGrid grid{as_numbers(x_m, "x_m"), as_numbers(y_m, "y_m"), as_numbers(z_m, "z_m"), {0}, {}};
  if (!t_s.is_none()) grid.t_s = as_numbers(t_s, "t_s");
  const auto size = [](const std::vector<double>& axis) { return static_cast<py::ssize_t>(axis.size()); };
  const py::ssize_t t = size(grid.t_s), z = size(grid.z_m), y = size(grid.y_m), x = size(grid.x_m);
  const auto velocity = t_s.is_none() ? as_array<double>(velocity_m_s, "velocity_m_s", {z, y, x, 3})
                                      : as_array<double>(velocity_m_s, "velocity_m_s", {t, z, y, x, 3});
  for (py::ssize_t k = 0; k < velocity.size(); k += 3) grid.values.emplace_back(velocity.data() + k);
  return gridded_current(std::move(grid));
}

/// speed_rad_s: (n,); cosine_m_s, sine_m_s: (n, 2).
std::shared_ptr<const Current> harmonic(const py::object& speed_rad_s, const py::object& cosine_m_s,
                                        const py::object& sine_m_s) {
  const auto speed = as_numbers(speed_rad_s, "speed_rad_s");
  const auto n = static_cast<py::ssize_t>(speed.size());
  const auto cosine = as_array<double>(cosine_m_s, "cosine_m_s", {n, 2}),
             sine = as_array<double>(sine_m_s, "sine_m_s", {n, 2});
  std::vector<Harmonic> all;
  for (py::ssize_t k = 0; k < n; ++k) {
    all.push_back(
        {speed[static_cast<std::size_t>(k)], {cosine.at(k, 0), cosine.at(k, 1)}, {sine.at(k, 0), sine.at(k, 1)}});
  }
  return harmonic_current(std::move(all));
}

}  // namespace

void bind_currents(py::module_& m) {
  py::class_<Current, std::shared_ptr<Current>>(
      m, "Current", "A current: a function of position and time. Its constructors raise ValueError.")
      .def_static(
          "layered",
          [](const py::object& depth_m, const py::object& velocity_m_s) {
            return std::const_pointer_cast<Current>(
                layered_current(as_numbers(depth_m, "depth_m"), as_points(velocity_m_s, "velocity_m_s")));
          },
          py::arg("depth_m"), py::arg("velocity_m_s"),
          "Return a steady current, linear between levels. depth_m: (n,), increasing; velocity_m_s: (n, 3).")
      .def_static(
          "tidal",
          [](const py::object& amplitude, double period_s, double phase_rad) {
            return std::const_pointer_cast<Current>(
                tidal_current(as_vector3(amplitude, "amplitude_m_s"), period_s, phase_rad));
          },
          py::arg("amplitude_m_s"), py::arg("period_s"), py::arg("phase_rad") = 0.0,
          "Return a tidal current: amplitude_m_s (3,) times sin(2 pi t / period_s + phase_rad).")
      .def_static(
          "harmonic",
          [](const py::object& speed_rad_s, const py::object& cosine_m_s, const py::object& sine_m_s) {
            return std::const_pointer_cast<Current>(harmonic(speed_rad_s, cosine_m_s, sine_m_s));
          },
          py::arg("speed_rad_s"), py::arg("cosine_m_s"), py::arg("sine_m_s"),
          "Return the sum of cosine_m_s cos(speed t) + sine_m_s sin(speed t): speed_rad_s (n,), others (n, 2), east\n"
          "and north.")
      .def_static(
          "gusty",
          [](const py::object& sigma, double correlation_time_s, std::uint64_t seed) {
            return std::const_pointer_cast<Current>(
                gusty_current(as_vector3(sigma, "sigma_m_s"), correlation_time_s, seed));
          },
          py::arg("sigma_m_s"), py::arg("correlation_time_s"), py::arg("seed") = 0,
          "Return Gauss-Markov gusts with standard deviation sigma_m_s (3,) and zero mean.")
      .def_static(
          "gridded",
          [](const py::object& x_m, const py::object& y_m, const py::object& z_m, const py::object& velocity_m_s,
             const py::object& t_s) {
            return std::const_pointer_cast<Current>(gridded(x_m, y_m, z_m, velocity_m_s, t_s));
          },
          py::arg("x_m"), py::arg("y_m"), py::arg("z_m"), py::arg("velocity_m_s"), py::arg("t_s") = py::none(),
          "Return a steady field, velocity_m_s (nz, ny, nx, 3) on increasing axes, or with t_s one that varies,\n"
          "velocity_m_s (nt, nz, ny, nx, 3): linear along each axis, constant beyond the edges.")
      .def(
          "velocity_m_s",
          [](const Current& current, const py::object& point_m, double time_s) {
            return current.at(as_vector3(point_m, "point_world_m"), time_s).velocity_m_s;
          },
          py::arg("point_world_m"), py::arg("time_s") = 0.0, "(3,)");
}

}  // namespace uwsim::bindings
