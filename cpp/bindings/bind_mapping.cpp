#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <tuple>

#include "arrays.h"
#include "bind.h"
#include "points.h"
#include "uwsim/mapping/occupancy_map.h"
#include "uwsim/sonar/depth_string.h"

namespace uwsim::bindings {
namespace {

std::string_view utf8(const py::str& text) {
  Py_ssize_t size = 0;
  const char* data = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (!data) {
    PyErr_Clear();
    throw InvalidValue("depth_string: holds a letter that is none (a lone surrogate)");
  }
  return {data, static_cast<std::size_t>(size)};
}

MapFormat format_named(const std::string& name) {
  require(name == "bt" || name == "ot", "map.format", "'" + name + "'", "must be 'bt' or 'ot'");
  return name == "bt" ? MapFormat::bt : MapFormat::ot;
}

void bind_depth_string(py::module_& m) {
  m.def(
      "encode_depth_string",
      [](const py::object& ranges_m, double range_max_m) {
        const FloatArray ranges = as_float32(ranges_m, "ranges_m", {-1});
        return encode_depth_string(span_of(ranges), range_max_m);
      },
      py::arg("ranges_m"), py::arg("range_max_m"),
      "The published depthArray text: C#'s G7 text of each range, each followed by the letter a.\n"
      "ranges_m: (n,) float32, in [0, range_max_m], or inf (no echo), which is written as range_max_m.\n"
      "Raises ValueError that names the beam on anything else.");
  m.def(
      "decode_depth_string",
      [](const py::str& text, std::size_t beams, double range_limit_m) {
        return move_out(decode_depth_string(utf8(text), beams, range_limit_m));
      },
      py::arg("text"), py::arg("beams"), py::arg("range_limit_m"),
      "Ranges of a depthArray text, (beams,) float32; values greater than range_limit_m become inf.\n"
      "Raises ValueError that names the beam unless the text is exactly `beams` plain decimals, each followed by a.");
}

void bind_occupancy_map(py::module_& m) {
  py::class_<OccupancyMap>(m, "OccupancyMap", "octomap::OcTree of the system's OctoMap, about an origin in the world.")
      .def(py::init([](double resolution_m, const py::object& origin_world_m) {
             return OccupancyMap(resolution_m, as_vector3(origin_world_m, "map.origin_world_m"));
           }),
           py::arg("resolution_m"), py::arg("origin_world_m"))
      .def_static(
          "read",
          [](const std::filesystem::path& path, const py::object& origin_world_m) {
            const Eigen::Vector3d origin = as_vector3(origin_world_m, "map.origin_world_m");
            return released([&] { return OccupancyMap::read(path.string(), origin); });
          },
          py::arg("path"), py::arg("origin_world_m"),
          "A map from a .bt or .ot file. Raises OSError if it cannot be read, ValueError if it is no sound map of\n"
          "OctoMap's. Releases the GIL.")
      .def_property_readonly("resolution_m", &OccupancyMap::resolution_m)
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
            released([&] { map.insert_scan(span_of(points), origin, max_range_m); });
          },
          py::arg("points_world_m"), py::arg("origin_world_m"), py::arg("max_range_m"),
          "points_world_m: (n, 3) float32; NaN and inf are skipped. origin_world_m: (3,) float64. Raises ValueError,\n"
          "inserting nothing, on shapes, on an origin that is not finite and outside OctoMap's cube. Releases the GIL.")
      .def(
          "occupied_voxels",
          [](const OccupancyMap& map) { return rows_out(released([&] { return map.occupied_voxels_world_m(); })); },
          "(n, 3) float64: centres of the finest voxels, world, in Morton order. Releases the GIL.")
      .def(
          "free_voxels",
          [](const OccupancyMap& map) { return rows_out(released([&] { return map.free_voxels_world_m(); })); },
          "(n, 3) float64: centres of the finest voxels, world, in Morton order. Releases the GIL.")
      .def(
          "statistics",
          [](const OccupancyMap& map) {
            const MapStatistics s = released([&] { return map.statistics(); });
            return std::make_tuple(s.occupied_voxels, s.free_voxels, s.nodes, s.memory_bytes);
          },
          "(occupied voxels, free voxels, nodes, bytes of memory). Releases the GIL.")
      .def(
          "state_at",
          [](const OccupancyMap& map, const py::object& points_world_m) {
            const auto points = as_array<double>(points_world_m, "points_world_m", {-1, 3});
            return move_out(released([&] { return map.state_at(span_of(points)); }));
          },
          py::arg("points_world_m"),
          "points_world_m: (n, 3) float64, finite. Returns (n,) int8: 1 occupied, 0 free, -1 unknown. Releases the "
          "GIL.")
      .def(
          "to_bytes",
          [](const OccupancyMap& map, const std::string& format) {
            const MapFormat wanted = format_named(format);
            return py::bytes(released([&] { return map.to_bytes(wanted); }));
          },
          py::arg("format"), "The bytes of a 'bt' or 'ot' file. Releases the GIL.")
      .def(
          "write",
          [](const OccupancyMap& map, const std::filesystem::path& path, const std::string& format) {
            const MapFormat wanted = format_named(format);
            released([&] { map.write(path.string(), wanted); });
          },
          py::arg("path"), py::arg("format"), "Atomically. Raises OSError. Releases the GIL.");
}

}  // namespace

void bind_mapping(py::module_& m) {
  bind_depth_string(m);
  bind_occupancy_map(m);
}

}  // namespace uwsim::bindings
