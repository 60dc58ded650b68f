#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <tuple>

#include "bindings/core/points.h"
#include "bindings/mapping/bind_map.h"
#include "bindings/mapping/binders.h"
#include "uwsim/mapping/atomic_file.h"

namespace uwsim::bindings {
namespace {

using CountArray = py::array_t<std::int64_t, py::array::c_style>;

/// Converts integers, (m,). Fractions are refused, not rounded.
CountArray as_counts(const py::object& object, const char* name) {
  const auto any = as_array<double>(object, name, {-1});
  for (py::ssize_t i = 0; i < any.size(); ++i) {
    const double count = any.data()[i];
    require(count == std::floor(count) && std::abs(count) <= 0x1p53, name, count, "must be whole numbers up to 2^53");
  }
  return as_array<std::int64_t>(object, name, {-1});
}

MapFormat format_named(const std::string& name) {
  require(name == "bt" || name == "ot", "map.format", "'" + name + "'", "must be 'bt' or 'ot'");
  return name == "bt" ? MapFormat::bt : MapFormat::ot;
}

void bind_options(py::module_& m) {
  py::enum_<MapEngineKind>(m, "MapEngine")
      .value("OCTOMAP", MapEngineKind::octomap)
      .value("BRICKS", MapEngineKind::bricks);
  py::enum_<InstructionSet>(m, "InstructionSet",
                            "The instruction set of the brick engine's kernels; results do not depend on it.")
      .value("BEST", InstructionSet::best)
      .value("PORTABLE", InstructionSet::portable)
      .value("AVX2", InstructionSet::avx2)
      .value("AVX512", InstructionSet::avx512);
  py::class_<MapOptions>(m, "MapOptions", "The engine of a map, and its probabilities of hit, miss and clamping.")
      .def(py::init([](MapEngineKind engine, double hit, double miss, double clamping_min, double clamping_max,
                       InstructionSet instruction_set, bool count_outside) {
             return MapOptions{engine,
                               {hit, miss, clamping_min, clamping_max},
                               instruction_set,
                               count_outside ? OnOutside::count : OnOutside::refuse};
           }),
           py::kw_only(), py::arg("engine"), py::arg("hit"), py::arg("miss"), py::arg("clamping_min"),
           py::arg("clamping_max"), py::arg("instruction_set"), py::arg("count_outside"));
}

void bind_map(py::module_& m) {
  MapClass map(m, "OccupancyMap", "OctoMap's octree about an origin in the world.");
  map.def(py::init([](double resolution_m, const py::object& origin_world_m, const MapOptions& options) {
            return OccupancyMap(resolution_m, as_vector3(origin_world_m, "map.origin_world_m"), options);
          }),
          py::arg("resolution_m"), py::arg("origin_world_m"), py::arg("options"))
      .def_static(
          "read",
          [](const std::filesystem::path& path, const py::object& origin_world_m, const MapOptions& options) {
            const Eigen::Vector3d origin = as_vector3(origin_world_m, "map.origin_world_m");
            return without_gil([&] { return OccupancyMap::read(path.string(), origin, options); });
          },
          py::arg("path"), py::arg("origin_world_m"), py::arg("options"),
          "Read a .bt or .ot file. Raises OSError if it cannot be read, ValueError if it is not a valid OctoMap\n"
          "file. Releases the GIL.")
      .def_property_readonly("resolution_m", &OccupancyMap::resolution_m)
      .def_property_readonly("engine", &OccupancyMap::engine)
      .def_property_readonly("origin_world_m",
                             [](const OccupancyMap& map) {
                               const Eigen::Vector3d origin = map.origin_world_m();
                               return move_out(std::vector<double>(origin.data(), origin.data() + 3));
                             })
      .def(
          "insert_scan",
          [](OccupancyMap& map, const py::object& points_world_m, const py::object& origin_world_m,
             double max_range_m) {
            const FloatArray points = as_point_rows(points_world_m, "scan.points_world_m");
            const Eigen::Vector3d origin = as_vector3(origin_world_m, "scan.origin_world_m");
            without_gil([&] { map.insert_scan(span_of(points), origin, max_range_m); });
          },
          py::arg("points_world_m"), py::arg("origin_world_m"), py::arg("max_range_m"),
          "Insert one ping. points_world_m: (n, 3) float32; NaN and inf are skipped. origin_world_m: (3,)\n"
          "float64. Raises ValueError, without inserting anything, for wrong shapes, a non-finite origin and\n"
          "points outside OctoMap's cube. Releases the GIL.")
      .def(
          "insert_scans",
          [](OccupancyMap& map, const py::object& points_world_m, const py::object& counts,
             const py::object& origins_world_m, double max_range_m, int threads) {
            const FloatArray points = as_point_rows(points_world_m, "scans.points_world_m");
            const CountArray points_each = as_counts(counts, "scans.counts");
            const auto origins = as_array<double>(origins_world_m, "scans.origins_world_m", {-1, 3});
            without_gil([&] {
              map.insert_scans(span_of(points), span_of(points_each), span_of(origins), max_range_m, threads);
            });
          },
          py::arg("points_world_m"), py::arg("counts"), py::arg("origins_world_m"), py::arg("max_range_m"),
          py::arg("threads"),
          "Insert pings in order. points_world_m: (n, 3) float32, the points of all pings; counts: (m,) int64,\n"
          "the number of points in each; origins_world_m: (m, 3) float64. Raises ValueError like insert_scan,\n"
          "without inserting any ping. Releases the GIL.")
      .def(
          "occupied_voxels",
          [](const OccupancyMap& map) { return rows_out(without_gil([&] { return map.occupied_voxels_world_m(); })); },
          "Return the centres of the occupied voxels, (n, 3) float64, world frame, at the finest level, in Morton\n"
          "order. Releases the GIL.")
      .def(
          "free_voxels",
          [](const OccupancyMap& map) { return rows_out(without_gil([&] { return map.free_voxels_world_m(); })); },
          "Return the centres of the free voxels, (n, 3) float64, world frame, at the finest level, in Morton\n"
          "order. Releases the GIL.")
      .def(
          "statistics",
          [](const OccupancyMap& map) {
            const MapStatistics s = without_gil([&] { return map.statistics(); });
            return std::make_tuple(s.occupied_voxels, s.free_voxels, s.nodes, s.memory_bytes, s.outside_points);
          },
          "Return (occupied voxels, free voxels, nodes, bytes of memory, discarded points). Releases the GIL.")
      .def(
          "count",
          [](const OccupancyMap& map) {
            const VoxelCounts counts = without_gil([&] { return map.count(); });
            return std::make_tuple(counts.occupied, counts.free);
          },
          "Return (occupied voxels, free voxels). Releases the GIL.")
      .def(
          "to_bytes",
          [](const OccupancyMap& map, const std::string& format) {
            const MapFormat wanted = format_named(format);
            return py::bytes(without_gil([&] { return map.to_bytes(wanted); }));
          },
          py::arg("format"), "Return the bytes of a 'bt' or 'ot' file. Releases the GIL.")
      .def(
          "write",
          [](const OccupancyMap& map, const std::filesystem::path& path, const std::string& format) {
            const MapFormat wanted = format_named(format);
            without_gil([&] { map.write(path.string(), wanted); });
          },
          py::arg("path"), py::arg("format"),
          "Write a 'bt' or 'ot' file atomically. Raises OSError. Releases the GIL.");
  bind_map_queries(map);
  bind_map_planning(map);
}

}  // namespace

void bind_occupancy_map(py::module_& m) {
  m.def("remove_unfinished_files", &remove_unfinished_files,
        "Remove the temporary files of all maps being written, for a process that ends while other threads are\n"
        "writing.");
  bind_options(m);
  bind_map(m);
}

}  // namespace uwsim::bindings
