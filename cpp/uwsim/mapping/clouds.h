#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

/// What PCL does for a map: the links from a LaserScan to it, filters, a ground plane, and a cloud laid onto another,
/// all on pcl::PointCloud<pcl::PointXYZ>. Points are x, y, z by rows, in metres; PCL keeps them as float32, so
/// coordinates far from zero lose digits (0.2 mm at 4 km). Filters drop points that are not finite, fits refuse them.
/// The same points in the same order give the same bytes.
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

/// pcl::VoxelGrid: the centroid of the points in each cube of edge voxel_m, whose corners are at multiples of voxel_m;
/// x counts fastest, then y, then z. Throws InvalidValue when the cloud's box has 2^31 cubes or more.
std::vector<float> voxel_grid(std::span<const float> points_m, double voxel_m);

/// pcl::PassThrough: the points whose coordinate on `axis` (0 x, 1 y, 2 z) is in [min_m, max_m], in their order.
std::vector<float> pass_through(std::span<const float> points_m, int axis, double min_m, double max_m);

/// pcl::StatisticalOutlierRemoval (Rusu et al. 2008): drops the points whose mean distance to their `neighbours`
/// nearest ones is more than the mean of that over the cloud and `deviations` standard deviations. Throws InvalidValue
/// unless there are more points than neighbours, or none at all.
std::vector<float> remove_outliers(std::span<const float> points_m, int neighbours, double deviations);

/// normal . p + offset_m = 0; the normal is of length 1 and looks up. inliers: 1 or 0 for each point.
struct PlaneFit {
  Eigen::Vector3d normal;
  double offset_m;
  std::vector<std::uint8_t> inliers;
};

/// pcl::RandomSampleConsensus (Fischler and Bolles 1981) for the plane, inclined by max_slope_rad at most, that has the
/// most points within distance_m, then least squares over these. PCL's own fixed seed: the same points give the same
/// plane. Throws InvalidValue when there is none.
PlaneFit ground_plane(std::span<const float> points_m, double distance_m, double max_slope_rad);

/// rms_m: of the distances from the source's points to their nearest in the target, over those within reach; overlap:
/// the share of these. converged: the steps became negligible before the iterations ran out.
struct Registration {
  Eigen::Matrix4d target_from_source;
  double rms_m;
  double overlap;
  int iterations;
  bool converged;
};

/// pcl::IterativeClosestPoint (Besl and McKay 1992), point to point, from a rigid guess, in double precision about the
/// target's middle. Points further than max_distance_m from the other cloud do not pull.
Registration register_cloud(std::span<const float> source_m, std::span<const float> target_m,
                            const Eigen::Matrix4d& guess, double max_distance_m, int max_iterations);

}  // namespace uwsim
