#include <tuple>

#include "bindings/binders.h"
#include "bindings/core/points.h"
#include "bindings/mapping/bind_map.h"

namespace uwsim::bindings {
namespace {

/// Returns cubes as arrays: centres (n, 3), edges (n,) and log-odds (n,).
std::tuple<DoubleOut, DoubleOut, FloatOut> columns(MapCubes&& cubes) {
  return {rows_out(std::move(cubes.centres_world_m)), move_out(std::move(cubes.edges_m)),
          move_out(std::move(cubes.log_odds))};
}

void bind_points(MapClass& map) {
  map.def(
         "state_at",
         [](const OccupancyMap& self, const py::object& points_world_m) {
           const auto points = as_array<double>(points_world_m, "points_world_m", {-1, 3});
           return move_out(without_gil([&] { return self.state_at(span_of(points)); }));
         },
         py::arg("points_world_m"),
         "Return the state at points_world_m, (n, 3) float64, finite: (n,) int8, 1 occupied, 0 free, -1 unknown.\n"
         "Releases the GIL.")
      .def(
          "log_odds_at",
          [](const OccupancyMap& self, const py::object& points_world_m) {
            const auto points = as_array<double>(points_world_m, "points_world_m", {-1, 3});
            return move_out(without_gil([&] { return self.log_odds_at(span_of(points)); }));
          },
          py::arg("points_world_m"),
          "Return the log-odds at points_world_m, (n, 3) float64, finite: (n,) float32, NaN where unknown.\n"
          "Releases the GIL.")
      .def(
          "cast_rays",
          [](const OccupancyMap& self, const py::object& origins_world_m, const py::object& directions_world,
             bool ignore_unknown, double max_range_m) {
            const auto origins = as_array<double>(origins_world_m, "rays.origins_world_m", {-1, 3});
            const auto directions = as_array<double>(directions_world, "rays.directions_world", {-1, 3});
            OccupancyMap::Casts casts = without_gil(
                [&] { return self.cast_rays(span_of(origins), span_of(directions), ignore_unknown, max_range_m); });
            return std::make_tuple(move_out(std::move(casts.ends)), rows_out(std::move(casts.voxel_centres_world_m)));
          },
          py::arg("origins_world_m"), py::arg("directions_world"), py::arg("ignore_unknown"), py::arg("max_range_m"),
          "Cast rays through the map. origins_world_m, directions_world: (n, 3) float64. Returns where the rays\n"
          "end, (n,) int8: 1 in an occupied voxel, 0 at the maximum range or the cube's edge, -1 in an unknown\n"
          "voxel; and the centres of the last voxels, (n, 3) float64. Releases the GIL.");
}

void bind_cubes(MapClass& map) {
  map.def(
         "bounds",
         [](const OccupancyMap& self) -> py::object {
           const std::optional<MapBounds> found = without_gil([&] { return self.bounds(); });
           return found ? py::cast(std::make_tuple(found->low_world_m, found->high_world_m)) : py::none();
         },
         "Return the low and high corners, (3,) float64 each, of the box around the known voxels; None if there are\n"
         "none. Releases the GIL.")
      .def(
          "leaves", [](const OccupancyMap& self) { return columns(without_gil([&] { return self.leaves(); })); },
          "Return the leaves of the pruned tree: centres (n, 3) float64, edges (n,) float64, log-odds (n,)\n"
          "float32. Releases the GIL.")
      .def(
          "cells",
          [](const OccupancyMap& self, int depth) { return columns(without_gil([&] { return self.cells(depth); })); },
          py::arg("depth"),
          "Return the cubes at a depth of the tree, 1 to 16, in the form of leaves(). Releases the GIL.")
      .def(
          "voxels_in",
          [](const OccupancyMap& self, const py::object& low_world_m, const py::object& high_world_m) {
            const Eigen::Vector3d low = as_vector3(low_world_m, "box.low_world_m");
            const Eigen::Vector3d high = as_vector3(high_world_m, "box.high_world_m");
            return columns(without_gil([&] { return self.voxels_in(low, high); }));
          },
          py::arg("low_world_m"), py::arg("high_world_m"),
          "Return the finest voxels whose centres are in a box, in the form of leaves(). low_world_m,\n"
          "high_world_m: (3,) float64. Releases the GIL.")
      .def(
          "changed_voxels",
          [](OccupancyMap& self) {
            OccupancyMap::Changes changes = without_gil([&] { return self.changed_voxels(); });
            return std::make_tuple(rows_out(std::move(changes.voxel_centres_world_m)),
                                   move_out(std::move(changes.states)));
          },
          "Return the voxels whose state has changed since the last call: centres (n, 3) float64, states (n,)\n"
          "int8. Releases the GIL.")
      .def(
          "changed_occupancy",
          [](OccupancyMap& self) {
            OccupancyMap::OccupancyChanges changes = without_gil([&] { return self.changed_occupancy(); });
            return std::make_tuple(rows_out(std::move(changes.cells)), move_out(std::move(changes.occupied)));
          },
          "Return the voxels that became occupied, or are no longer occupied, since the last call: their offsets\n"
          "from the origin in voxels, (n, 3) int16, and whether they are occupied now, (n,) uint8. Releases the\n"
          "GIL.");
}

}  // namespace

void bind_map_queries(MapClass& map) {
  bind_points(map);
  bind_cubes(map);
  map.def(
         "merge", [](OccupancyMap& self, const OccupancyMap& other) { without_gil([&] { self.merge(other); }); },
         py::arg("other"), "Add the log-odds of another map. Raises ValueError. Releases the GIL.")
      .def("model",
           [](const OccupancyMap& self) {
             const OccupancyModel model = without_gil([&] { return self.model(); });
             return std::make_tuple(model.hit, model.miss, model.clamping_min, model.clamping_max);
           })
      .def(
          "set_model",
          [](OccupancyMap& self, double hit, double miss, double clamping_min, double clamping_max) {
            without_gil([&] { self.set_model({hit, miss, clamping_min, clamping_max}); });
          },
          py::arg("hit"), py::arg("miss"), py::arg("clamping_min"), py::arg("clamping_max"),
          "Set the probabilities for later scans. Raises ValueError. Releases the GIL.");
}

}  // namespace uwsim::bindings
