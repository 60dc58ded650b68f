#pragma once

#include <pybind11/pybind11.h>

/// One binder for each folder of cpp/uwsim, called by module.cpp. A folder with several binding files declares their
/// binders in its own binders.h.
namespace uwsim::bindings {

void bind_core(pybind11::module_& m);
void bind_world(pybind11::module_& m);
void bind_rays(pybind11::module_& m);
void bind_acoustics(pybind11::module_& m);
void bind_vehicle(pybind11::module_& m);
void bind_control(pybind11::module_& m);
void bind_sensors(pybind11::module_& m);
void bind_sonar(pybind11::module_& m);
void bind_camera(pybind11::module_& m);
void bind_mapping(pybind11::module_& m);
void bind_estimation(pybind11::module_& m);
void bind_sim(pybind11::module_& m);
void bind_autopilots(pybind11::module_& m);

}  // namespace uwsim::bindings
