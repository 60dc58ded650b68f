#pragma once

#include "bindings/core/arrays.h"
#include "uwsim/mapping/occupancy_map.h"

/// The class OccupancyMap is bound in three files: bind_occupancy_map.cpp, bind_map_queries.cpp and bind_planning.cpp.
namespace uwsim::bindings {

using MapClass = py::class_<OccupancyMap>;
using DoubleOut = py::array_t<double>;
using FloatOut = py::array_t<float>;

/// Binds queries, changes, merging and the sensor model.
void bind_map_queries(MapClass& map);
/// Binds queries for planners.
void bind_map_planning(MapClass& map);

}  // namespace uwsim::bindings
