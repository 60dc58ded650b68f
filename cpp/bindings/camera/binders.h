#pragma once

#include <pybind11/pybind11.h>

namespace uwsim::bindings {

void bind_optics(pybind11::module_& m);
void bind_picture(pybind11::module_& m);
void bind_camera_scene(pybind11::module_& m);

}  // namespace uwsim::bindings
