#include <pybind11/complex.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <complex>
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

void bind_radiation(py::module_& m) {
  using Sections = std::vector<std::tuple<Matrix6d, Matrix6d, double, double>>;
  using Forces = py::array_t<std::complex<double>, py::array::c_style | py::array::forcecast>;
  using Drifts = py::array_t<double, py::array::c_style | py::array::forcecast>;
  py::class_<Radiation, std::shared_ptr<Radiation>>(
      m, "Radiation", "The waves that a floating hull makes and deflects: Cummins' equation, and diffraction.")
      .def(
          py::init([](const Matrix6d& added_mass, const Sections& sections, const Forces& diffraction,
                      double least_rad_s, double most_rad_s, double wet_volume_m3, const std::optional<Drifts>& drift) {
            require(
                diffraction.ndim() == 4 && diffraction.shape(0) == Radiation::kDivisions && diffraction.shape(3) == 6,
                "diffraction", diffraction.ndim(), "must be of shape (4, frequencies, headings, 6)");
            auto made = std::make_shared<Radiation>();
            made->added_mass = added_mass;
            for (const auto& [by_speed, by_place, omega, damping] : sections)
              made->sections.push_back({by_speed, by_place, omega, damping});
            made->frequencies = static_cast<std::size_t>(diffraction.shape(1));
            made->headings = static_cast<std::size_t>(diffraction.shape(2));
            const std::complex<double>* value = diffraction.data();
            made->diffraction.resize(Radiation::kDivisions * made->frequencies * made->headings);
            for (Radiation::Force& force : made->diffraction) {
              for (int axis = 0; axis < 6; ++axis, ++value) force.row(axis) << value->real(), value->imag();
            }
            if (drift) {
              require(drift->ndim() == 4 && drift->shape(3) == 3 &&
                          std::equal(drift->shape(), drift->shape() + 3, diffraction.shape()),
                      "drift", drift->ndim(), "must be of shape (4, frequencies, headings, 3)");
              const double* each = drift->data();
              for (py::ssize_t k = 0; k < drift->size(); k += 3)
                made->drift.emplace_back(each[k], each[k + 1], each[k + 2]);
            }
            made->least_rad_s = least_rad_s;
            made->most_rad_s = most_rad_s;
            made->wet_volume_m3 = wet_volume_m3;
            made->check();
            return made;
          }),
          py::arg("added_mass"), py::arg("sections"), py::arg("diffraction"), py::arg("least_rad_s"),
          py::arg("most_rad_s"), py::arg("wet_volume_m3"), py::arg("drift") = py::none(),
          "added_mass: (6, 6), at infinite frequency. sections: R (6, 6), Q (6, 6), frequency [rad/s] and damping\n"
          "ratio of the terms (R s + Q) / (s^2 + 2 zeta omega s + omega^2). diffraction: complex (4, frequencies,\n"
          "headings, 6), force on a fixed hull beyond that on its slices, in each division, per metre of a wave's\n"
          "amplitude, with exp(-i omega t), from least_rad_s to most_rad_s and all around from the body's x. Body\n"
          "frame, about the origin. drift: (4, frequencies, headings, 3), the mean force along x and y and moment\n"
          "about z that the rest of the model lacks, per squared metre of amplitude. Raises ValueError.")
      .def_property_readonly(
          "added_mass", [](const Radiation& r) { return r.added_mass; }, "(6, 6)")
      .def("impedance", &Radiation::impedance, py::arg("s"),
           "Return K(s) (6, 6), complex: B + i omega (A - A_infinity) at s = i omega.")
      .def(
          "diffraction",
          [](const Radiation& r, double omega_rad_s, double heading_rad, std::size_t division) {
            require(division < Radiation::kDivisions, "division", division, "must be at most 3");
            const Radiation::Force force = r.diffraction_at(division, omega_rad_s, heading_rad);
            return Eigen::Vector<std::complex<double>, 6>(force.col(0) + std::complex<double>(0, 1) * force.col(1));
          },
          py::arg("omega_rad_s"), py::arg("heading_rad"), py::arg("division") = Radiation::kDivisions - 1,
          "Return X (6,), complex [N/m, N], of a hull cut into 2^division slices.")
      .def("share", &Radiation::share, py::arg("submerged_volume_m3"), py::arg("up"), py::arg("cover"),
           "Return the weight of these terms, from 0 to 1.");
}

}  // namespace

void bind_vehicle(py::module_& m) {
  bind_radiation(m);
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
      .def_readwrite("buoyancy_share_step_m", &CraftParameters::buoyancy_share_step_m)
      .def_property(
          "radiation", [](const CraftParameters& p) { return std::const_pointer_cast<Radiation>(p.radiation); },
          [](CraftParameters& p, std::shared_ptr<Radiation> radiation) { p.radiation = std::move(radiation); },
          "A Radiation: the waves that the floating hull makes; None: none are modelled.");

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
