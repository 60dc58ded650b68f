#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <tuple>

#include "arrays.h"
#include "bind.h"
#include "uwsim/mapping/clouds.h"
#include "uwsim/mapping/occupancy_map.h"
#include "uwsim/sonar/depth_string.h"

namespace uwsim::bindings {
namespace {

/// as_array<float>, but a finite float64 that float32 cannot hold is an error and not an infinity.
FloatArray as_float32(const py::object& object, const char* name, std::initializer_list<py::ssize_t> shape) {
  if (!py::isinstance<py::array_t<float>>(object)) {
    const auto wide = as_array<double>(object, name, shape);
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
      const double value = wide.data()[i];
      require(!std::isfinite(value) || std::abs(value) <= std::numeric_limits<float>::max(), name, value,
              "must fit a float32");
    }
  }
  return as_array<float>(object, name, shape);
}

FloatArray as_point_rows(const py::object& object, const char* name) { return as_float32(object, name, {-1, 3}); }

template <typename T>
std::span<const T> span_of(const py::array_t<T, py::array::c_style>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <typename T>
py::array_t<T> rows_out(std::vector<T>&& values) {
  const auto rows = static_cast<py::ssize_t>(values.size() / 3);
  return move_out(std::move(values), {rows, 3});
}

/// Runs `work` without the GIL.
template <typename Work>
auto released(const Work& work) {
  const py::gil_scoped_release release;
  return work();
}

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

void bind_clouds(py::module_& m) {
  m.def(
      "scan_to_points",
      [](const py::object& ranges_m, double angle_min_rad, double angle_increment_rad, double range_min_m,
         double range_max_m) {
        const FloatArray ranges = as_float32(ranges_m, "scan.ranges", {-1});
        const ScanGeometry geometry{angle_min_rad, angle_increment_rad, range_min_m, range_max_m};
        return rows_out(released([&] { return scan_to_points(span_of(ranges), geometry); }));
      },
      py::arg("ranges_m"), py::arg("angle_min_rad"), py::arg("angle_increment_rad"), py::arg("range_min_m"),
      py::arg("range_max_m"),
      "A LaserScan's points in its own frame (x forward, y left), (n, 3) float32, beams in order; as in "
      "laser_geometry\n"
      "only range_min <= range < range_max counts. ranges_m: (beams,) float32. Raises ValueError. Releases the GIL.");
  m.def(
      "transform_points",
      [](const py::object& points_source_m, const py::object& target_from_source) {
        const FloatArray points = as_point_rows(points_source_m, "points_source_m");
        const auto matrix = as_array<double>(target_from_source, "target_from_source", {4, 4});
        const Eigen::Matrix4d transform = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data());
        return rows_out(released([&] { return transform_points(span_of(points), transform); }));
      },
      py::arg("points_source_m"), py::arg("target_from_source"),
      "pcl::transformPointCloud: (n, 3) float32 in, (n, 3) float32 out. target_from_source: (4, 4) float64, rigid.\n"
      "Raises ValueError. Releases the GIL.");
  m.def(
      "filter_range",
      [](const py::object& points_m, double min_m, double max_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        return rows_out(released([&] { return filter_range(span_of(points), min_m, max_m); }));
      },
      py::arg("points_m"), py::arg("min_m"), py::arg("max_m"),
      "The points whose distance to the origin is in [min_m, max_m]; (n, 3) float32. Raises ValueError. Releases the\n"
      "GIL.");
  m.def(
      "remove_box",
      [](const py::object& points_m, const py::object& box_min_m, const py::object& box_max_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        const Eigen::Vector3d low = as_vector3(box_min_m, "box_min_m"), high = as_vector3(box_max_m, "box_max_m");
        return rows_out(released([&] { return remove_box(span_of(points), low, high); }));
      },
      py::arg("points_m"), py::arg("box_min_m"), py::arg("box_max_m"),
      "pcl::CropBox, negative: the points outside the box, whose faces belong to it; (n, 3) float32. box_*_m: (3,)\n"
      "float64. Points that are not finite drop out. Raises ValueError. Releases the GIL.");
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
  bind_clouds(m);
  bind_occupancy_map(m);
}

}  // namespace uwsim::bindings
