#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

/// The links between a LaserScan and a map, done by PCL on pcl::PointCloud<pcl::PointXYZ>. Points are x, y, z by rows,
/// in metres; PCL keeps them as float32, so coordinates far from zero lose digits (0.2 mm at 4 km).
namespace uwsim {

/// sensor_msgs/LaserScan without its ranges. Beam i looks along angle_min + i * angle_increment about +z, from +x
/// towards +y.
struct ScanGeometry {
  double angle_min_rad;
  double angle_increment_rad;
  double range_min_m;
  double range_max_m;
};

/// Points in the scan's own frame (base_scan: x forward, y left, z = 0), in the order of the beams. As laser_geometry
/// does, a range counts if range_min <= range < range_max: infinity and NaN drop out.
std::vector<float> scan_to_points(std::span<const float> ranges_m, const ScanGeometry& geometry);

/// target_from_source: a rigid transform. As many points as came in.
std::vector<float> transform_points(std::span<const float> points_source_m, const Eigen::Matrix4d& target_from_source);

/// The points whose distance to the frame's origin is in [min_m, max_m].
std::vector<float> filter_range(std::span<const float> points_m, double min_m, double max_m);

/// The points outside an axis-aligned box, faces included in the box: takes the vehicle's own echoes out of a cloud in
/// the vehicle's frame. Points that are not finite drop out.
std::vector<float> remove_box(std::span<const float> points_m, const Eigen::Vector3d& box_min_m,
                              const Eigen::Vector3d& box_max_m);

}  // namespace uwsim
