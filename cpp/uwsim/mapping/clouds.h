#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

/// Point-cloud operations by PCL, on pcl::PointCloud<pcl::PointXYZ>: conversion of a LaserScan to points in the world,
/// filters, a ground plane. Points are rows of x, y, z in metres. PCL stores them as float32, so coordinates far from
/// the origin lose digits (0.2 mm at 4 km). Filters discard non-finite points; fits refuse them. The same points in the
/// same order produce the same bytes.
namespace uwsim {

/// sensor_msgs/LaserScan without its ranges. Beam i points at angle_min + i * angle_increment about +z, counted from +x
/// towards +y.
struct ScanGeometry {
  double angle_min_rad;
  double angle_increment_rad;
  double range_min_m;
  double range_max_m;
};

/// Returns the points of a scan in the scanner's frame (base_scan: x forward, y left, z = 0), in beam order. Ranges are
/// used if range_min <= range < range_max, as in laser_geometry; infinity and NaN are discarded.
std::vector<float> scan_to_points(std::span<const float> ranges_m, const ScanGeometry& geometry);

/// Transforms points by target_from_source, a rigid transform. All points are returned, in order.
std::vector<float> transform_points(std::span<const float> points_source_m, const Eigen::Matrix4d& target_from_source);

/// Returns target_from_source, from two rigid transforms.
Eigen::Matrix4d relative_transform(const Eigen::Matrix4d& world_from_target, const Eigen::Matrix4d& world_from_source);

/// Returns the points whose distance to the frame's origin is in [min_m, max_m].
std::vector<float> filter_range(std::span<const float> points_m, double min_m, double max_m);

/// Returns the points outside an axis-aligned box; the box's faces count as inside. For example, it removes the
/// vehicle's own echoes from a cloud in the vehicle's frame.
std::vector<float> remove_box(std::span<const float> points_m, const Eigen::Vector3d& box_min_m,
                              const Eigen::Vector3d& box_max_m);

/// Returns the points of a scan in the world, except those inside a box in the body's frame, by the functions above: in
/// the scanner's frame by scan_to_points and filter_range, with the scan's limits; in the body's frame by
/// transform_points and remove_box; and in the world by transform_points. The points stay in one cloud in between.
std::vector<float> scan_to_world(std::span<const float> ranges_m, const ScanGeometry& geometry,
                                 const Eigen::Vector3d& box_min_m, const Eigen::Vector3d& box_max_m,
                                 const Eigen::Matrix4d& world_from_body, const Eigen::Matrix4d& world_from_sonar);

/// pcl::VoxelGrid: returns the centroid of the points in each cube with edge voxel_m and corners at multiples of
/// voxel_m. Cubes are ordered with x varying fastest, then y, then z. Throws InvalidValue if the cloud's box has 2^31
/// cubes or more.
std::vector<float> voxel_grid(std::span<const float> points_m, double voxel_m);

/// pcl::PassThrough: returns the points whose coordinate along `axis` (0 x, 1 y, 2 z) is in [min_m, max_m], in the
/// original order.
std::vector<float> pass_through(std::span<const float> points_m, int axis, double min_m, double max_m);

/// pcl::StatisticalOutlierRemoval (Rusu et al. 2008): discards the points whose mean distance to their `neighbours`
/// nearest points exceeds the mean of that distance over the cloud by more than `deviations` standard deviations.
/// Throws InvalidValue unless the cloud is empty or has more points than neighbours.
std::vector<float> remove_outliers(std::span<const float> points_m, int neighbours, double deviations);

/// The plane normal . p + offset_m = 0; the normal has length 1 and points up. inliers: 1 or 0 for each point.
struct PlaneFit {
  Eigen::Vector3d normal;
  double offset_m;
  std::vector<std::uint8_t> inliers;
};

/// pcl::RandomSampleConsensus (Fischler and Bolles 1981) for the plane that has the most points within distance_m and
/// is inclined by at most max_slope_rad, followed by a least-squares fit to these points. PCL's seed is fixed, so the
/// same points produce the same plane. Throws InvalidValue if there is no such plane.
PlaneFit ground_plane(std::span<const float> points_m, double distance_m, double max_slope_rad);

}  // namespace uwsim
