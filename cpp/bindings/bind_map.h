#pragma once

#include "arrays.h"
#include "uwsim/mapping/occupancy_map.h"

/// OccupancyMap's class is bound in two files.
namespace uwsim::bindings {

using MapClass = py::class_<OccupancyMap>;
using DoubleOut = py::array_t<double>;
using FloatOut = py::array_t<float>;

/// Questions, changes, merging and probabilities.
void bind_map_queries(MapClass& map);

}  // namespace uwsim::bindings
