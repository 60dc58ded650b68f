#pragma once

#include <pybind11/pybind11.h>

namespace uwsim::bindings {

void bind_parameter(pybind11::module_& m);

}  // namespace uwsim::bindings
