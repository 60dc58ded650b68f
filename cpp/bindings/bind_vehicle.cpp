#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "arrays.h"
#include "bind.h"
#include "convert.h"
#include "uwsim/vehicle/craft.h"
#include "uwsim/world/water.h"

namespace uwsim::bindings {
namespace {

BodyState as_state(const py::object& position_m, const py::object& orientation_xyzw, const py::object& velocity_body) {
  BodyState state;
  state.world_from_body = as_pose(position_m, orientation_xyzw, "state");
  const auto v = as_array<double>(velocity_body, "velocity_body", {6});
  state.velocity_body = Eigen::Map<const Vector6d>(v.data());
  return state;
}

}  // namespace

void bind_vehicle(py::module_& m) {
  py::class_<BodyState>(m, "BodyState", "Pose and velocity of a body; six-vectors (linear, angular) in the body frame.")
      .def(py::init(&as_state), py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("velocity_body"))
      .def_property_readonly(
          "position_world_m", [](const BodyState& s) { return s.world_from_body.position_m; }, "(3,) [m]")
      .def_property_readonly(
          "orientation_xyzw",
          [](const BodyState& s) -> Eigen::Vector4d { return s.world_from_body.orientation.coeffs(); }, "(4,)")
      .def_property_readonly(
          "world_from_body", [](const BodyState& s) { return s.world_from_body.matrix(); }, "(4, 4)")
      .def_readonly("velocity_body", &BodyState::velocity_body, "(6,) [m/s, rad/s]");

  py::class_<SolidProperties>(m, "SolidProperties")
      .def_readonly("volume_m3", &SolidProperties::volume_m3)
      .def_readonly("centroid_m", &SolidProperties::centroid_m, "(3,) [m]")
      .def_readonly("inertia_per_density_m5", &SolidProperties::inertia_per_density_m5,
                    "(3, 3) [m^5], about the centroid; times density gives kg m^2");
  m.def(
      "solid_properties",
      [](const py::object& vertices_m, const py::object& triangles) {
        const TriangleMesh mesh{as_points(vertices_m, "vertices_m"), as_triangles(triangles, "triangles")};
        require_closed(mesh, "mesh");
        return solid_properties(mesh);
      },
      py::arg("vertices_m"), py::arg("triangles"),
      "Volume, centroid and inertia of a closed mesh (n, 3), (m, 3). Raises ValueError when it is open or inverted.");

  py::class_<CraftParameters>(m, "CraftParameters",
                              "A craft's coefficients in Fossen's order: surge, sway, heave, roll, pitch, yaw.")
      .def(py::init<>())
      .def_readwrite("mass_kg", &CraftParameters::mass_kg)
      .def_readwrite("centre_of_mass_body_m", &CraftParameters::centre_of_mass_body_m, "(3,) [m]")
      .def_readwrite("inertia_kg_m2", &CraftParameters::inertia_kg_m2, "(3, 3), about the centre of mass")
      .def_readwrite("added_mass", &CraftParameters::added_mass, "(6, 6) M_A [kg, kg m, kg m^2]")
      .def_readwrite("linear_damping", &CraftParameters::linear_damping, "(6, 6) [N s/m, N m s/rad]")
      .def_readwrite("quadratic_damping", &CraftParameters::quadratic_damping, "(6, 6) [N s^2/m^2, N m s^2/rad^2]");

  py::class_<Craft, std::shared_ptr<Craft>>(
      m, "Craft", "A rigid body in fluid: equations of motion after Fossen 2011, ch. 6 and 8.")
      .def(py::init(
               [](const CraftParameters& parameters, const py::object& vertices_body_m, const py::object& triangles) {
                 return std::make_shared<Craft>(parameters, BuoyantHull({as_points(vertices_body_m, "vertices_body_m"),
                                                                         as_triangles(triangles, "triangles")}));
               }),
           py::arg("parameters"), py::arg("vertices_body_m"), py::arg("triangles"),
           "vertices_body_m: (n, 3); triangles: (m, 3), closed and winding outward. Raises ValueError.")
      .def(
          "acceleration_body",
          [](const Craft& craft, const BodyState& state, const Vector6d& tau_body, const Water& water, double time_s) {
            return craft.acceleration_body(state, tau_body, water, time_s);
          },
          py::arg("state"), py::arg("tau_body"), py::arg("water"), py::arg("time_s") = 0.0,
          "nu' (6,) under the actuators' wrench tau_body (6,).")
      .def(
          "submerged_fraction",
          [](const Craft& craft, const BodyState& state, const std::optional<Water>& water, double time_s) {
            return craft.submerged_fraction(state.world_from_body, water ? *water : Water(), time_s);
          },
          py::arg("state"), py::arg("water") = py::none(), py::arg("time_s") = 0.0,
          "0 dry .. 1 fully under water; without water, under z = 0.")
      .def("kinetic_energy_j", &Craft::kinetic_energy_j, py::arg("state"), "Of the body and the still water around it.")
      .def_property_readonly(
          "volume_m3", [](const Craft& craft) { return craft.hull().solid().volume_m3; }, "Displaced when submerged.");
}

}  // namespace uwsim::bindings
