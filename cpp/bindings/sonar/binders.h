#pragma once

#include <pybind11/pybind11.h>

namespace uwsim::bindings {

void bind_multibeam(pybind11::module_& m);
void bind_acoustic_multibeam(pybind11::module_& m);
void bind_imaging(pybind11::module_& m);
void bind_high_points(pybind11::module_& m);
void bind_depth_image(pybind11::module_& m);
void bind_depth_string(pybind11::module_& m);

}  // namespace uwsim::bindings
