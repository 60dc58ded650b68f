#include <pybind11/stl.h>

#include "bindings/core/arrays.h"
#include "bindings/world/binders.h"
#include "uwsim/world/sediment.h"

namespace uwsim::bindings {

void bind_sediment(py::module_& m) {
  py::class_<SedimentClouds>(m, "SedimentClouds", "The sediment in the water at one time.")
      .def_property_readonly(
          "table",
          [](const SedimentClouds& clouds) {
            std::vector<double> rows;
            for (const SedimentCloud& cloud : clouds.all) {
              rows.insert(rows.end(), {cloud.middle_m.x(), cloud.middle_m.y(), cloud.middle_m.z(), cloud.across_m,
                                       cloud.up_m, cloud.mass_kg});
            }
            return move_out(std::move(rows), {static_cast<py::ssize_t>(clouds.all.size()), 6});
          },
          "A row for each cloud, (n, 6): middle on the bed [m], standard deviations across and up [m], mass [kg].")
      .def_property_readonly(
          "extinction_m2_kg", [](const SedimentClouds& clouds) { return clouds.sediment.extinction_m2_kg(); },
          "Attenuation of light by each kilogram [m^2/kg].")
      .def_property_readonly(
          "settling_m_s", [](const SedimentClouds& clouds) { return clouds.sediment.settling_m_s(); },
          "Speed at which a grain sinks [m/s].")
      .def(
          "columns_kg_m2",
          [](const SedimentClouds& clouds, const py::object& origins_m, const py::object& ends_m) {
            const auto from = as_array<double>(origins_m, "origins_m", {-1, 3});
            const auto to = as_array<double>(ends_m, "ends_m", {from.shape(0), 3});
            std::vector<double> columns(static_cast<std::size_t>(from.shape(0)));
            for (py::ssize_t k = 0; k < from.shape(0); ++k) {
              const Eigen::Vector3d origin = Eigen::Vector3d::Map(from.data(k, 0));
              const Eigen::Vector3d along = Eigen::Vector3d::Map(to.data(k, 0)) - origin;
              const double length_m = along.norm();
              if (!(length_m > 0)) continue;
              for (const SedimentCloud& cloud : clouds.all) {
                columns[static_cast<std::size_t>(k)] += cloud.column_kg_m2(origin, along / length_m, length_m);
              }
            }
            return move_out(std::move(columns), {from.shape(0)});
          },
          py::arg("origins_m"), py::arg("ends_m"),
          "Return the sediment along straight lines between points (n, 3), (n,) [kg/m^2]. Raises ValueError.");
}

}  // namespace uwsim::bindings
