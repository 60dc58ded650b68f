#pragma once

#include <pybind11/pybind11.h>

/// The binders of controllers, called by bind_control.
namespace uwsim::bindings {

void bind_motion_controller(pybind11::module_& m);
void bind_path_follower(pybind11::module_& m);

}  // namespace uwsim::bindings
