#include <pybind11/eigen.h>

#include <tuple>

#include "bindings/core/points.h"
#include "bindings/mapping/binders.h"
#include "uwsim/mapping/clouds.h"

namespace uwsim::bindings {
namespace {

Eigen::Matrix4d as_transform(const py::object& object, const char* name) {
  const auto matrix = as_array<double>(object, name, {4, 4});
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data());
}

void bind_links(py::module_& m) {
  m.def(
      "scan_to_points",
      [](const py::object& ranges_m, double angle_min_rad, double angle_increment_rad, double range_min_m,
         double range_max_m) {
        const FloatArray ranges = as_float32(ranges_m, "scan.ranges", {-1});
        const ScanGeometry geometry{angle_min_rad, angle_increment_rad, range_min_m, range_max_m};
        return rows_out(without_gil([&] { return scan_to_points(span_of(ranges), geometry); }));
      },
      py::arg("ranges_m"), py::arg("angle_min_rad"), py::arg("angle_increment_rad"), py::arg("range_min_m"),
      py::arg("range_max_m"),
      "Return the points of a LaserScan in its own frame (x forward, y left), (n, 3) float32, in beam order.\n"
      "As in laser_geometry, only ranges with range_min <= range < range_max are used. ranges_m: (beams,)\n"
      "float32. Raises ValueError. Releases the GIL.");
  m.def(
      "transform_points",
      [](const py::object& points_source_m, const py::object& target_from_source) {
        const FloatArray points = as_point_rows(points_source_m, "points_source_m");
        const Eigen::Matrix4d transform = as_transform(target_from_source, "target_from_source");
        return rows_out(without_gil([&] { return transform_points(span_of(points), transform); }));
      },
      py::arg("points_source_m"), py::arg("target_from_source"),
      "Transform points by pcl::transformPointCloud. points_source_m: (n, 3) float32. target_from_source: (4,\n"
      "4) float64, rigid. Returns (n, 3) float32. Raises ValueError. Releases the GIL.");
  m.def(
      "relative_transform",
      [](const py::object& world_from_target, const py::object& world_from_source) {
        const Eigen::Matrix4d target = as_transform(world_from_target, "world_from_target");
        return relative_transform(target, as_transform(world_from_source, "world_from_source"));
      },
      py::arg("world_from_target"), py::arg("world_from_source"),
      "Return target_from_source, (4, 4) float64, from rigid transforms. Raises ValueError.");
  m.def(
      "filter_range",
      [](const py::object& points_m, double min_m, double max_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        return rows_out(without_gil([&] { return filter_range(span_of(points), min_m, max_m); }));
      },
      py::arg("points_m"), py::arg("min_m"), py::arg("max_m"),
      "Return the points whose distance to the origin is in [min_m, max_m], (n, 3) float32. Raises\n"
      "ValueError. Releases the GIL.");
  m.def(
      "remove_box",
      [](const py::object& points_m, const py::object& box_min_m, const py::object& box_max_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        const Eigen::Vector3d low = as_vector3(box_min_m, "box_min_m"), high = as_vector3(box_max_m, "box_max_m");
        return rows_out(without_gil([&] { return remove_box(span_of(points), low, high); }));
      },
      py::arg("points_m"), py::arg("box_min_m"), py::arg("box_max_m"),
      "Return the points outside a box, whose faces count as inside, by a negative pcl::CropBox; (n, 3)\n"
      "float32. box_*_m: (3,) float64. Discards non-finite points. Raises ValueError. Releases the GIL.");
  m.def(
      "scan_to_world",
      [](const py::object& ranges_m, double angle_min_rad, double angle_increment_rad, double range_min_m,
         double range_max_m, const py::object& box_min_m, const py::object& box_max_m,
         const py::object& world_from_body, const py::object& world_from_sonar) {
        const FloatArray ranges = as_float32(ranges_m, "scan.ranges", {-1});
        const ScanGeometry geometry{angle_min_rad, angle_increment_rad, range_min_m, range_max_m};
        const Eigen::Vector3d low = as_vector3(box_min_m, "box_min_m"), high = as_vector3(box_max_m, "box_max_m");
        const Eigen::Matrix4d body = as_transform(world_from_body, "world_from_body"),
                              sonar = as_transform(world_from_sonar, "world_from_sonar");
        return rows_out(without_gil([&] { return scan_to_world(span_of(ranges), geometry, low, high, body, sonar); }));
      },
      py::arg("ranges_m"), py::arg("angle_min_rad"), py::arg("angle_increment_rad"), py::arg("range_min_m"),
      py::arg("range_max_m"), py::arg("box_min_m"), py::arg("box_max_m"), py::arg("world_from_body"),
      py::arg("world_from_sonar"),
      "Return the points of a LaserScan in the world without those inside a box in the body's frame, (n, 3)\n"
      "float32: scan_to_points, filter_range, transform_points, remove_box and transform_points in one call.\n"
      "ranges_m: (beams,) float32. box_*_m: (3,). world_from_*: (4, 4), rigid. Raises ValueError. Releases\n"
      "the GIL.");
}

void bind_filters(py::module_& m) {
  m.def(
      "voxel_grid",
      [](const py::object& points_m, double voxel_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        return rows_out(without_gil([&] { return voxel_grid(span_of(points), voxel_m); }));
      },
      py::arg("points_m"), py::arg("voxel_m"),
      "Return the centroid of the points in each cube with edge voxel_m, by pcl::VoxelGrid. points_m: (n, 3)\n"
      "float32. Returns (k, 3) float32. Discards non-finite points. Raises ValueError. Releases the GIL.");
  m.def(
      "pass_through",
      [](const py::object& points_m, int axis, double min_m, double max_m) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        return rows_out(without_gil([&] { return pass_through(span_of(points), axis, min_m, max_m); }));
      },
      py::arg("points_m"), py::arg("axis"), py::arg("min_m"), py::arg("max_m"),
      "Return the points whose coordinate along axis 0, 1 or 2 is in [min_m, max_m], by pcl::PassThrough; (n,\n"
      "3) float32. Discards non-finite points. Raises ValueError. Releases the GIL.");
  m.def(
      "remove_outliers",
      [](const py::object& points_m, int neighbours, double deviations) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        return rows_out(without_gil([&] { return remove_outliers(span_of(points), neighbours, deviations); }));
      },
      py::arg("points_m"), py::arg("neighbours"), py::arg("deviations"),
      "Remove outliers by pcl::StatisticalOutlierRemoval; (n, 3) float32. Discards non-finite points. Raises\n"
      "ValueError. Releases the GIL.");
}

void bind_fits(py::module_& m) {
  m.def(
      "ground_plane",
      [](const py::object& points_m, double distance_m, double max_slope_rad) {
        const FloatArray points = as_point_rows(points_m, "points_m");
        PlaneFit fit = without_gil([&] { return ground_plane(span_of(points), distance_m, max_slope_rad); });
        py::array_t<std::uint8_t> inliers = move_out(std::move(fit.inliers));
        return std::make_tuple(fit.normal, fit.offset_m, inliers.view("bool"));
      },
      py::arg("points_m"), py::arg("distance_m"), py::arg("max_slope_rad"),
      "Fit a ground plane by pcl::RandomSampleConsensus. points_m: (n, 3) float32, finite. Returns the upward\n"
      "normal (3,), the offset [m] with normal . p + offset = 0, and the inliers (n,) bool. Raises\n"
      "ValueError. Releases the GIL.");
}

}  // namespace

void bind_clouds(py::module_& m) {
  bind_links(m);
  bind_filters(m);
  bind_fits(m);
}

}  // namespace uwsim::bindings
