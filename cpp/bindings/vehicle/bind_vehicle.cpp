#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/vehicle/binders.h"
#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/core/recently_made.h"
#include "uwsim/vehicle/added_mass.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/vehicle/panels.h"
#include "uwsim/world/water.h"

namespace uwsim::bindings {
namespace {

/// Returns a hull that is shared by all vehicles with the same mesh, regardless of their other parameters, since
/// measuring and tabulating a hull takes 2 ms.
std::shared_ptr<const BuoyantHull> hull_of(TriangleMesh mesh_body, std::optional<std::size_t> division = std::nullopt) {
  static RecentlyMade<BuoyantHull> known;
  const auto is_wanted = [&](const BuoyantHull& hull) {
    return hull.division() == division && hull.mesh_body().triangles == mesh_body.triangles &&
           hull.mesh_body().vertices_m == mesh_body.vertices_m;
  };
  return known.find_or_make(true, is_wanted,
                            [&] { return std::make_shared<const BuoyantHull>(std::move(mesh_body), division); });
}

}  // namespace

void bind_vehicle(py::module_& m) {
  py::class_<CraftParameters>(
      m, "CraftParameters",
      "Mass and hydrodynamic coefficients in Fossen's order: surge, sway, heave, roll, pitch, yaw.")
      .def(py::init<>())
      .def_readwrite("mass_kg", &CraftParameters::mass_kg)
      .def_readwrite("centre_of_mass_body_m", &CraftParameters::centre_of_mass_body_m, "(3,) [m]")
      .def_readwrite("inertia_kg_m2", &CraftParameters::inertia_kg_m2, "(3, 3), about the centre of mass")
      .def_readwrite("added_mass", &CraftParameters::added_mass, "(6, 6) M_A [kg, kg m, kg m^2]")
      .def_readwrite("linear_damping", &CraftParameters::linear_damping, "(6, 6) [N s/m, N m s/rad]")
      .def_readwrite("quadratic_damping", &CraftParameters::quadratic_damping, "(6, 6) [N s^2/m^2, N m s^2/rad^2]")
      .def_readwrite("munk_share", &CraftParameters::munk_share,
                     "The fraction of the Munk moment that remains; 1 in an ideal fluid.")
      .def_readwrite("coefficients_volume_m3", &CraftParameters::coefficients_volume_m3,
                     "The submerged volume at which added mass and damping hold; 0: that of the whole hull.")
      .def_readwrite("crossflow_length_m", &CraftParameters::crossflow_length_m,
                     "The length along x over which the drag in sway and heave is spread; 0: at the origin.")
      .def_readwrite("buoyancy_share", &CraftParameters::buoyancy_share,
                     "buoyancy as a fraction of rho(z) g V, at depths from 0 in equal steps; if empty, 1")
      .def_readwrite("buoyancy_share_step_m", &CraftParameters::buoyancy_share_step_m);

  py::class_<Craft, std::shared_ptr<Craft>>(
      m, "Craft", "A rigid body in a fluid: equations of motion after Fossen 2011, ch. 6 and 8.")
      .def(py::init([](const CraftParameters& parameters, const py::object& vertices_body_m,
                       const py::object& triangles, std::optional<std::size_t> division) {
             return std::make_shared<Craft>(parameters, hull_of({as_points(vertices_body_m, "vertices_body_m"),
                                                                 as_triangles(triangles, "triangles")},
                                                                division));
           }),
           py::arg("parameters"), py::arg("vertices_body_m"), py::arg("triangles"), py::arg("division") = py::none(),
           "vertices_body_m: (n, 3); triangles: (m, 3), closed and winding outward. Raises ValueError.")
      .def(
          "acceleration_body",
          [](const Craft& craft, const BodyState& state, const Vector6d& tau_body, const Water& water, double time_s) {
            return craft.acceleration_body(state, tau_body, water, time_s);
          },
          py::arg("state"), py::arg("tau_body"), py::arg("water"), py::arg("time_s") = 0.0,
          "Return nu' (6,) under the actuators' wrench tau_body (6,).")
      .def(
          "submerged_fraction",
          [](const Craft& craft, const BodyState& state, const std::optional<Water>& water, double time_s) {
            return craft.submerged_fraction(state.world_from_body, water ? *water : Water(), time_s);
          },
          py::arg("state"), py::arg("water") = py::none(), py::arg("time_s") = 0.0,
          "Return the submerged fraction, from 0 (dry) to 1 (fully submerged). Without water, that below z = 0.")
      .def("kinetic_energy_j", &Craft::kinetic_energy_j, py::arg("state"),
           "Return the kinetic energy of the body and the still water around it.")
      .def_property_readonly(
          "volume_m3", [](const Craft& craft) { return craft.hull().solid().volume_m3; },
          "The volume that the hull displaces when submerged.");
  m.def(
      "added_mass",
      [](const py::object& vertices_m, const py::object& triangles, double density_kg_m3, std::size_t panels) {
        const TriangleMesh mesh{as_points(vertices_m, "vertices_m"), as_triangles(triangles, "triangles")};
        return without_gil([&] { return added_mass(refined(mesh, panels), density_kg_m3, usable_threads()); });
      },
      py::arg("vertices_m"), py::arg("triangles"), py::arg("density_kg_m3"), py::arg("panels"),
      "Return the added mass (6, 6) of a closed hull about its origin [kg, kg m, kg m^2] in ideal flow, far from "
      "surface\n"
      "and bed, by a boundary-element method (Steinbach 2008, sec. 6.6). vertices_m: (n, 3). triangles: (m, 3), "
      "winding\n"
      "outward. panels: triangles are split until there are so many, at most 10000. The result is a lower bound, "
      "apart\n"
      "from quadrature. Uses all threads. Raises ValueError.");
  bind_actuators(m);
}

}  // namespace uwsim::bindings
