#pragma once

#include <pybind11/pybind11.h>

/// One function a folder of cpp/uwsim, each in its own bind_<folder>.cpp.
namespace uwsim::bindings {

void bind_core(pybind11::module_& m);
void bind_actuators(pybind11::module_& m);
void bind_acoustics(pybind11::module_& m);
void bind_water(pybind11::module_& m);
void bind_world(pybind11::module_& m);
void bind_vehicle(pybind11::module_& m);
void bind_camera(pybind11::module_& m);
void bind_sonar(pybind11::module_& m);
void bind_clouds(pybind11::module_& m);
void bind_acoustic_multibeam(pybind11::module_& m);
void bind_imaging(pybind11::module_& m);
void bind_depth_string(pybind11::module_& m);
void bind_occupancy_map(pybind11::module_& m);
void bind_sensors(pybind11::module_& m);
void bind_sim(pybind11::module_& m);

}  // namespace uwsim::bindings
