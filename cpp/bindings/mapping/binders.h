#pragma once

#include <pybind11/pybind11.h>

namespace uwsim::bindings {

void bind_clouds(pybind11::module_& m);
void bind_occupancy_map(pybind11::module_& m);
void bind_distance_field(pybind11::module_& m);  ///< after the map's class

}  // namespace uwsim::bindings
