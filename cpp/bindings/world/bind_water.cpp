#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/world/binders.h"
#include "uwsim/core/check.h"
#include "uwsim/world/sea_water.h"
#include "uwsim/world/water.h"

namespace uwsim::bindings {
namespace {

/// pybind11 cannot hold pointers to const; the bound classes have no setters.
template <typename T>
std::optional<std::shared_ptr<T>> or_none(const std::shared_ptr<const T>& part) {
  if (!part) return std::nullopt;
  return std::const_pointer_cast<T>(part);
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

/// temperature_deg_c, salinity_psu: (nt, nz, ny, nx).
std::shared_ptr<const WaterMasses> masses(const py::object& x_m, const py::object& y_m, const py::object& z_m,
                                          const py::object& t_s, const py::object& temperature_deg_c,
                                          const py::object& salinity_psu) {
  WaterMasses grid{as_numbers(x_m, "x_m"), as_numbers(y_m, "y_m"), as_numbers(z_m, "z_m"), as_numbers(t_s, "t_s"), {}};
  for (const std::vector<double>* axis : {&grid.t_s, &grid.z_m, &grid.y_m, &grid.x_m}) {
    require(!axis->empty() && std::ranges::is_sorted(*axis, std::less_equal<>()), "water.masses", axis->size(),
            "must have axes that rise");
  }
  const auto size = [](const std::vector<double>& axis) { return static_cast<py::ssize_t>(axis.size()); };
  const py::ssize_t t = size(grid.t_s), z = size(grid.z_m), y = size(grid.y_m), x = size(grid.x_m);
  const auto temperature = as_array<double>(temperature_deg_c, "temperature_deg_c", {t, z, y, x});
  const auto salinity = as_array<double>(salinity_psu, "salinity_psu", {t, z, y, x});
  for (py::ssize_t k = 0; k < temperature.size(); ++k) {
    const Eigen::Array2d each(temperature.data()[k], salinity.data()[k]);
    require(each(0) >= -2 && each(0) <= 40, "water.masses.temperature_deg_c", each(0), "must be in [-2, 40] deg C");
    require(each(1) >= 0 && each(1) <= 45, "water.masses.salinity_psu", each(1), "must be in [0, 45] psu");
    grid.values.push_back(each);
  }
  return std::make_shared<const WaterMasses>(std::move(grid));
}

std::shared_ptr<const Tide> tide(const py::object& constituents) {
  const auto rows = as_array<double>(constituents, "constituents", {-1, 3});
  std::vector<TidalConstituent> found;
  for (py::ssize_t k = 0; k < rows.shape(0); ++k) found.push_back({rows.at(k, 0), rows.at(k, 1), rows.at(k, 2)});
  return std::make_shared<const Tide>(std::move(found));
}

/// Returns the values (n,) of a function at points (n, width).
template <typename Function>
py::array_t<double> values_at(const py::object& points_m, const char* name, py::ssize_t width, Function function) {
  const auto points = as_array<double>(points_m, name, {-1, width});
  std::vector<double> values(static_cast<std::size_t>(points.shape(0)));
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = function(points.data(static_cast<py::ssize_t>(k), 0));
  return move_out(std::move(values));
}

py::array_t<double> surface_height(const Water& water, const py::object& xy_m, double time_s) {
  return values_at(xy_m, "xy_m", 2, [&](const double* p) { return water.surface_height_at(p[0], p[1], time_s); });
}

py::array_t<double> pressure_at(const Water& water, const py::object& points_m, double time_s) {
  return values_at(points_m, "points_world_m", 3,
                   [&](const double* p) { return water.pressure_pa(Eigen::Vector3d(p[0], p[1], p[2]), time_s); });
}

py::array_t<double> temperature_at(const Water& water, const py::object& points_m, double time_s) {
  return values_at(points_m, "points_world_m", 3,
                   [&](const double* p) { return water.temperature_deg_c(Eigen::Vector3d(p[0], p[1], p[2]), time_s); });
}

py::array_t<double> salinity_at(const Water& water, const py::object& points_m, double time_s) {
  return values_at(points_m, "points_world_m", 3,
                   [&](const double* p) { return water.salinity_at_psu(Eigen::Vector3d(p[0], p[1], p[2]), time_s); });
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

std::string water_text(const Water& water) {
  std::string text = "<Water: " + printed(water.density_at(0)) + " kg/m3, " + printed(water.temperature_deg_c(0)) +
                     " deg C, " + printed(water.salinity_at_psu(0)) + " psu at the surface";
  if (water.profile) text += "; a profile";
  if (const double speed_m_s = water.current_world_m_s.norm(); speed_m_s > 0) {
    text += "; a current of " + printed(speed_m_s) + " m/s";
  }
  if (!water.currents.empty()) text += "; currents: " + std::to_string(water.currents.size());
  return text + (water.waves ? "; waves>" : ">");
}

}  // namespace

void bind_sea_water(py::module_& m) {
  m.def(
      "sea_water_density_kg_m3",
      [](double t, double s, double p) {
        return p == 0 ? sea_water_density_kg_m3(t, s) : sea_water_density_kg_m3(t, s, p);
      },
      py::arg("temperature_deg_c"), py::arg("salinity_psu"), py::arg("gauge_pressure_pa") = 0.0,
      "Return the density by EOS-80 (UNESCO 44, 1983); gauge_pressure_pa: pressure above atmospheric. Raises\n"
      "ValueError.");
  m.def("sound_speed_m_s", py::overload_cast<double, double, double, std::string_view>(&sound_speed_m_s),
        py::arg("temperature_deg_c"), py::arg("salinity_psu"), py::arg("depth_m"), py::arg("equation") = "automatic",
        "Return the speed of sound in water [m/s] by unesco (Chen and Millero 1977), del_grosso (1974; both\n"
        "with Wong and Zhu's coefficients of 1995), belogolskii (1999, fresh water), leroy (2008), mackenzie\n"
        "(1981), medwin (1975), or the equation whose range of validity fits best. Raises ValueError.");
}

void bind_water(py::module_& m) {
  bind_waves(m);
  bind_currents(m);
  py::class_<WaterProfile, std::shared_ptr<WaterProfile>>(
      m, "WaterProfile", "Temperature, salinity, density and sound speed, linear in depth between levels.")
      .def(py::init(&profile), py::arg("depth_m"), py::arg("temperature_deg_c"), py::arg("salinity_psu"),
           py::arg("density_kg_m3"), py::arg("sound_speed_m_s") = py::none(),
           "Create a profile from arrays (n,), with increasing depths. Without sound_speed_m_s, the sound speed is\n"
           "computed from the other properties. Raises ValueError.");
  bind_sea_water(m);

  py::class_<Water>(
      m, "Water",
      "The water of a world: calm and uniform with one steady current, unless waves, a profile or currents\n"
      "are set.")
      .def(py::init<>())
      .def("__repr__", &water_text)
      .def_readwrite("density_kg_m3", &Water::density_kg_m3)
      .def_readwrite("gravity_m_s2", &Water::gravity_m_s2)
      .def_readwrite("atmospheric_pressure_pa", &Water::atmospheric_pressure_pa)
      .def_readwrite("surface_temperature_deg_c", &Water::surface_temperature_deg_c)
      .def_readwrite("bottom_temperature_deg_c", &Water::bottom_temperature_deg_c)
      .def_readwrite("bottom_depth_m", &Water::bottom_depth_m)
      .def_readwrite("salinity_psu", &Water::salinity_psu)
      .def_readwrite("compressible", &Water::compressible,
                     "whether pressure includes the compression of the water by its own weight (EOS-80)")
      .def_property(
          "sound_speed_equation", [](const Water& water) { return name_of(water.sound_speed_equation); },
          &Water::select_sound_speed_equation,
          "unesco, del_grosso, belogolskii, leroy, mackenzie or medwin; assign \"automatic\" for the best. Raises\n"
          "ValueError if the water in its present state exceeds the equation's range.")
      .def_readwrite("current_world_m_s", &Water::current_world_m_s)
      .def_property(
          "waves", [](const Water& water) { return or_none<Waves>(water.waves); },
          [](Water& water, std::optional<std::shared_ptr<Waves>> waves) { water.waves = waves.value_or(nullptr); },
          "None for a flat surface")
      .def_property(
          "profile", [](const Water& water) { return or_none<WaterProfile>(water.profile); },
          [](Water& water, std::optional<std::shared_ptr<WaterProfile>> profile) {
            water.profile = profile.value_or(nullptr);
          },
          "None for uniform density and salinity, with temperature linear down to bottom_depth_m")
      .def(
          "add_current",
          [](Water& water, std::shared_ptr<Current> current) { water.currents.push_back(std::move(current)); },
          py::arg("current"), "Add a current to current_world_m_s and to those added earlier.")
      .def(
          "set_tide", [](Water& water, const py::object& constituents) { water.tide = tide(constituents); },
          py::arg("constituents"),
          "Let the still surface move: rows (n, 3) of amplitude [m], speed [rad/s] and phase [rad], of the height\n"
          "amplitude cos(speed t - phase). Raises ValueError.")
      .def_property_readonly(
          "tide_bound_m", [](const Water& water) { return water.tide ? water.tide->bound_m() : 0.0; },
          "bound of the tide's height above or below z = 0; 0 without a tide")
      .def(
          "set_masses",
          [](Water& water, const py::object& x_m, const py::object& y_m, const py::object& z_m, const py::object& t_s,
             const py::object& temperature_deg_c, const py::object& salinity_psu) {
            water.masses = masses(x_m, y_m, z_m, t_s, temperature_deg_c, salinity_psu);
          },
          py::arg("x_m"), py::arg("y_m"), py::arg("z_m"), py::arg("t_s"), py::arg("temperature_deg_c"),
          py::arg("salinity_psu"),
          "Set temperature and salinity (nt, nz, ny, nx) on axes that rise, as instruments measure them. Raises\n"
          "ValueError.")
      .def("check", &Water::check,
           "Raise ValueError naming the field, its value, unit and rule if a parameter is invalid.")
      .def("pressure_pa", py::overload_cast<double>(&Water::pressure_pa, py::const_), py::arg("z_world_m"),
           "Return the absolute pressure of still water: p_atm + the integral of rho g, with compression.")
      .def("pressure_at_pa", &pressure_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "Return the absolute pressure (n,) at points (n, 3) under the waves at this time.")
      .def("density_at_kg_m3", &Water::density_at, py::arg("z_world_m"), "Return the density of still water.")
      .def("temperature_deg_c", py::overload_cast<double>(&Water::temperature_deg_c, py::const_), py::arg("z_world_m"))
      .def("salinity_at_psu", py::overload_cast<double>(&Water::salinity_at_psu, py::const_), py::arg("z_world_m"))
      .def("temperature_at_deg_c", &temperature_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "Return the temperature (n,) at points (n, 3): that of the masses, if there are any.")
      .def("salinity_at_points_psu", &salinity_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "Return the salinity (n,) at points (n, 3): that of the masses, if there are any.")
      .def("sound_speed_m_s", &Water::sound_speed_m_s, py::arg("z_world_m"),
           "Return the speed of sound, from the profile if it specifies one, else by temperature, salinity and\n"
           "pressure (sound_speed_equation).")
      .def("surface_height_m", &surface_height, py::arg("xy_m"), py::arg("time_s") = 0.0,
           "Return the surface height (n,) at positions (n, 2).")
      .def("velocity_m_s", &velocity_at, py::arg("points_world_m"), py::arg("time_s") = 0.0,
           "Return the velocity (n, 3) at points (n, 3), including currents and waves.");
}

}  // namespace uwsim::bindings
