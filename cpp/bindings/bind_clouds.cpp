#include "bind.h"
#include "points.h"
#include "uwsim/mapping/clouds.h"

namespace uwsim::bindings {

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

}  // namespace uwsim::bindings
