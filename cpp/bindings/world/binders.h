#pragma once

#include <pybind11/pybind11.h>

namespace uwsim::bindings {

void bind_currents(pybind11::module_& m);
void bind_fixed_world(pybind11::module_& m);
void bind_surface_sampler(pybind11::module_& m);
void bind_water(pybind11::module_& m);
void bind_waves(pybind11::module_& m);

}  // namespace uwsim::bindings
