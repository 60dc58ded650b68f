#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "arrays.h"
#include "bind.h"
#include "convert.h"
#include "uwsim/acoustics/sea_water.h"
#include "uwsim/world/water.h"

namespace uwsim::bindings {
namespace {

std::vector<double> as_numbers(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {-1});
  return {array.data(), array.data() + array.size()};
}

/// Python knows no const: what it holds has no setters.
template <typename T>
std::optional<std::shared_ptr<T>> given(const std::shared_ptr<const T>& part) {
  if (!part) return std::nullopt;
  return std::const_pointer_cast<T>(part);
}

std::shared_ptr<Waves> airy(double amplitude_m, double period_s, double heading_rad, double phase_rad, double depth_m,
                            double gravity_m_s2) {
  require(period_s > 0, "water.surface.period_s", period_s, "must be positive");
  const WaveComponent wave{amplitude_m, 2 * std::numbers::pi / period_s, heading_rad, phase_rad};
  return std::make_shared<Waves>(std::span(&wave, 1), depth_m, gravity_m_s2);
}

std::shared_ptr<WaterProfile> profile(const py::object& depth_m, const py::object& temperature_deg_c,
                                      const py::object& salinity_psu, const py::object& density_kg_m3,
                                      const py::object& sound_speed_m_s) {
  const auto depth = as_numbers(depth_m, "depth_m");
  const auto n = static_cast<py::ssize_t>(depth.size());
  const auto temperature = as_array<double>(temperature_deg_c, "temperature_deg_c", {n});
  const auto salinity = as_array<double>(salinity_psu, "salinity_psu", {n});
  const auto density = as_array<double>(density_kg_m3, "density_kg_m3", {n});
  std::vector<WaterLevel> levels(depth.size());
  for (py::ssize_t k = 0; k < n; ++k) {
    levels[static_cast<std::size_t>(k)] = {depth[static_cast<std::size_t>(k)], temperature.at(k), salinity.at(k),
                                           density.at(k), 0};
  }
  if (!sound_speed_m_s.is_none()) {
    const auto speed = as_array<double>(sound_speed_m_s, "sound_speed_m_s", {n});
    for (py::ssize_t k = 0; k < n; ++k) levels[static_cast<std::size_t>(k)].sound_speed_m_s = speed.at(k);
  }
  return std::make_shared<WaterProfile>(levels);
}

/// velocity_m_s: (nz, ny, nx, 3).
std::shared_ptr<const Current> gridded(const py::object& x_m, const py::object& y_m, const py::object& z_m,
                                       const py::object& velocity_m_s) {
  CurrentGrid grid{as_numbers(x_m, "x_m"), as_numbers(y_m, "y_m"), as_numbers(z_m, "z_m"), {}};
  const auto size = [](const std::vector<double>& axis) { return static_cast<py::ssize_t>(axis.size()); };
  const auto velocity =
      as_array<double>(velocity_m_s, "velocity_m_s", {size(grid.z_m), size(grid.y_m), size(grid.x_m), 3});
  for (py::ssize_t k = 0; k < velocity.size(); k += 3) grid.velocity_m_s.emplace_back(velocity.data() + k);
  return gridded_current(std::move(grid));
}

/// (n,) of a figure over points (n, width) at one time.
template <typename Figure>
py::array_t<double> over(const py::object& points_m, const char* name, py::ssize_t width, Figure figure) {
  const auto points = as_array<double>(points_m, name, {-1, width});
  std::vector<double> values(static_cast<std::size_t>(points.shape(0)));
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = figure(points.data(static_cast<py::ssize_t>(k), 0));
  return move_out(std::move(values));
}

py::array_t<double> surface_height(const Water& water, const py::object& xy_m, double time_s) {
  return over(xy_m, "xy_m", 2, [&](const double* p) { return water.surface_height_at(p[0], p[1], time_s); });
}

py::array_t<double> pressure_at(const Water& water, const py::object& points_m, double time_s) {
  return over(points_m, "points_world_m", 3,
              [&](const double* p) { return water.pressure_pa(Eigen::Vector3d(p[0], p[1], p[2]), time_s); });
}

py::array_t<double> velocity_at(const Water& water, const py::object& points_m, double time_s) {
  const auto points = as_points(points_m, "points_world_m");
  std::vector<double> values;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d v = water.flow_at(p, time_s).velocity_m_s;
    values.insert(values.end(), v.begin(), v.end());
  }
  return move_out(std::move(values), {static_cast<py::ssize_t>(points.size()), 3});
}

double sound_speed(const Water& water, double z_world_m) {
  const double given = water.given_sound_speed_m_s(z_world_m);
  if (given > 0) return given;
  return sound_speed_m_s(water.temperature_deg_c(z_world_m), water.salinity_at_psu(z_world_m),
                         std::max(0.0, Water::depth_m(z_world_m)));
}

void bind_waves(py::module_& m) {
  py::class_<Waves, std::shared_ptr<Waves>>(
      m, "Waves", "Linear waves on water of one depth, stretched to their own surface (Airy; Wheeler 1970).")
      .def_static("airy", &airy, py::arg("amplitude_m"), py::arg("period_s"), py::arg("heading_rad") = 0.0,
                  py::arg("phase_rad") = 0.0, py::arg("depth_m") = std::numeric_limits<double>::infinity(),
                  py::arg("gravity_m_s2") = 9.80665,
                  "One wave that runs towards heading_rad (from east, counter-clockwise). Raises ValueError.")
      .def_static(
          "jonswap",
          [](double height, double period, double enhancement, double heading, double spreading, int count,
             std::uint64_t seed, double depth_m, double gravity) {
            return std::make_shared<Waves>(
                Waves::jonswap({height, period, enhancement, heading, spreading, count, seed}, depth_m, gravity));
          },
          py::arg("significant_height_m"), py::arg("peak_period_s"), py::arg("peak_enhancement") = 3.3,
          py::arg("heading_rad") = 0.0, py::arg("spreading_exponent") = 0.0, py::arg("component_count") = 64,
          py::arg("seed") = 0, py::arg("depth_m") = std::numeric_limits<double>::infinity(),
          py::arg("gravity_m_s2") = 9.80665, "A sea of component_count waves. Raises ValueError.")
      .def_property_readonly("significant_height_m", &Waves::significant_height_m, "4 sqrt(m0)")
      .def_property_readonly("bound_m", &Waves::bound_m, "No crest is higher, no trough deeper.")
      .def_property_readonly("depth_m", &Waves::depth_m);
}

void bind_currents(py::module_& m) {
  py::class_<Current, std::shared_ptr<Current>>(m, "Current",
                                                "A current: a function of place and time. All raise ValueError.")
      .def_static(
          "layered",
          [](const py::object& depth_m, const py::object& velocity_m_s) {
            return std::const_pointer_cast<Current>(
                layered_current(as_numbers(depth_m, "depth_m"), as_points(velocity_m_s, "velocity_m_s")));
          },
          py::arg("depth_m"), py::arg("velocity_m_s"), "depth_m: (n,) rising; velocity_m_s: (n, 3). Linear between.")
      .def_static(
          "tidal",
          [](const py::object& amplitude, double period_s, double phase_rad) {
            return std::const_pointer_cast<Current>(
                tidal_current(as_vector3(amplitude, "amplitude_m_s"), period_s, phase_rad));
          },
          py::arg("amplitude_m_s"), py::arg("period_s"), py::arg("phase_rad") = 0.0,
          "amplitude_m_s (3,) times sin(2 pi t / period_s + phase_rad).")
      .def_static(
          "gusty",
          [](const py::object& sigma, double correlation_time_s, std::uint64_t seed) {
            return std::const_pointer_cast<Current>(
                gusty_current(as_vector3(sigma, "sigma_m_s"), correlation_time_s, seed));
          },
          py::arg("sigma_m_s"), py::arg("correlation_time_s"), py::arg("seed") = 0,
          "Gauss-Markov, of standard deviation sigma_m_s (3,) about no mean.")
      .def_static(
          "gridded",
          [](const py::object& x_m, const py::object& y_m, const py::object& z_m, const py::object& velocity_m_s) {
            return std::const_pointer_cast<Current>(gridded(x_m, y_m, z_m, velocity_m_s));
          },
          py::arg("x_m"), py::arg("y_m"), py::arg("z_m"), py::arg("velocity_m_s"),
          "A steady field, velocity_m_s (nz, ny, nx, 3) on rising axes: trilinear, held beyond its edges.")
      .def(
          "velocity_m_s",
          [](const Current& current, const py::object& point_m, double time_s) {
            return current.at(as_vector3(point_m, "point_world_m"), time_s).velocity_m_s;
          },
          py::arg("point_world_m"), py::arg("time_s") = 0.0, "(3,)");
}

}  // namespace

void bind_water(py::module_& m) {
  bind_waves(m);
  bind_currents(m);
  py::class_<WaterProfile, std::shared_ptr<WaterProfile>>(
      m, "WaterProfile", "Temperature, salinity, density and sound speed, linear in depth between levels.")
      .def(py::init(&profile), py::arg("depth_m"), py::arg("temperature_deg_c"), py::arg("salinity_psu"),
           py::arg("density_kg_m3"), py::arg("sound_speed_m_s") = py::none(),
           "Each (n,), depths rising; without sound_speed_m_s it follows from the others. Raises ValueError.");
  m.def("sea_water_density_kg_m3", &sea_water_density_kg_m3, py::arg("temperature_deg_c"), py::arg("salinity_psu"),
        "At atmospheric pressure, by EOS-80 (UNESCO 44, 1983).");

  py::class_<Water>(m, "Water",
                    "The water: still, even and with one steady current, unless waves, a profile or currents are set.")
      .def(py::init<>())
      .def_readwrite("density_kg_m3", &Water::density_kg_m3)
      .def_readwrite("gravity_m_s2", &Water::gravity_m_s2)
      .def_readwrite("atmospheric_pressure_pa", &Water::atmospheric_pressure_pa)
      .def_readwrite("surface_temperature_deg_c", &Water::surface_temperature_deg_c)
      .def_readwrite("bottom_temperature_deg_c", &Water::bottom_temperature_deg_c)
      .def_readwrite("bottom_depth_m", &Water::bottom_depth_m)
      .def_readwrite("salinity_psu", &Water::salinity_psu)
      .def_readwrite("current_world_m_s", &Water::current_world_m_s)
      .def_property(
          "waves", [](const Water& water) { return given<Waves>(water.waves); },
          [](Water& water, std::optional<std::shared_ptr<Waves>> waves) { water.waves = waves.value_or(nullptr); },
          "None: still")
      .def_property(
          "profile", [](const Water& water) { return given<WaterProfile>(water.profile); },
          [](Water& water, std::optional<std::shared_ptr<WaterProfile>> profile) {
            water.profile = profile.value_or(nullptr);
          },
          "None: one density and salinity, temperature linear down to bottom_depth_m")
      .def(
          "add_current",
          [](Water& water, std::shared_ptr<Current> current) { water.currents.push_back(std::move(current)); },
          py::arg("current"), "Adds to current_world_m_s and to those added before.")
      .def("check", &Water::check, "Raises ValueError that names the field, its value, unit and rule.")
      .def("pressure_pa", py::overload_cast<double>(&Water::pressure_pa, py::const_), py::arg("z_world_m"),
           "Absolute, of the water at rest: p_atm + the integral of rho g.")
      .def("pressure_at_pa", &pressure_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "(n, 3) -> (n,) absolute, under the waves of the moment.")
      .def("density_at_kg_m3", &Water::density_at, py::arg("z_world_m"), "At rest.")
      .def("temperature_deg_c", &Water::temperature_deg_c, py::arg("z_world_m"))
      .def("salinity_at_psu", &Water::salinity_at_psu, py::arg("z_world_m"))
      .def("sound_speed_m_s", &sound_speed, py::arg("z_world_m"),
           "As the profile gives it, else by temperature, salinity and depth (Mackenzie 1981).")
      .def("surface_height_m", &surface_height, py::arg("xy_m"), py::arg("time_s") = 0.0, "(n, 2) -> (n,)")
      .def("velocity_m_s", &velocity_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "(n, 3) -> (n, 3), current and waves together.");
}

}  // namespace uwsim::bindings
