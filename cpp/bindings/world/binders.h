#pragma once

#include <pybind11/pybind11.h>

#include <cmath>
#include <utility>

namespace uwsim::bindings {

using Pair = std::pair<double, double>;

/// Defines add_cover, whose arguments World and FixedWorld share.
template <typename Class, typename Function>
Class& def_add_cover(Class& world, Function add, const char* doc) {
  using pybind11::arg;
  const Pair any(-HUGE_VAL, HUGE_VAL);
  return world.def("add_cover", add, arg("name"), arg("meshes"), arg("stance") = "upright", arg("sunk") = 0.0,
                   arg("density_per_m2") = 1.0, arg("size_m") = Pair(0.1, 0.1), arg("size_exponent") = 0.0,
                   arg("depth_m") = any, arg("slope_rad") = any, arg("from_solids_m") = any, arg("patch_m") = 0.0,
                   arg("patch_share") = 1.0, arg("seed") = 0, arg("solid") = false, arg("drag_coefficient") = 0.0,
                   arg("leans_at_m_s") = HUGE_VAL, doc);
}

/// Defines add_school.
template <typename Class, typename Function>
Class& def_add_school(Class& world, Function add, const char* doc) {
  using pybind11::arg;
  return world.def("add_school", add, arg("name"), arg("count"), arg("shapes"), arg("position_m"), arg("round_m"),
                   arg("speed_m_s"), arg("spread_m"), arg("stroke_hz"), arg("clear_m"), arg("seed"), doc);
}

/// Defines add_plume.
template <typename Class, typename Function>
Class& def_add_plume(Class& world, Function add, const char* doc) {
  using pybind11::arg;
  return world.def("add_plume", add, arg("name"), arg("count"), arg("shapes"), arg("source_m"), arg("top_z_m"),
                   arg("drift_m_s"), arg("seed"), doc);
}

void bind_currents(pybind11::module_& m);
void bind_fixed_world(pybind11::module_& m);
void bind_surface_sampler(pybind11::module_& m);
void bind_water(pybind11::module_& m);
void bind_waves(pybind11::module_& m);

}  // namespace uwsim::bindings
