#include "uwsim/mapping/clouds.h"

#include <pcl/common/transforms.h>
#include <pcl/console/print.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/sample_consensus/ransac.h>
#include <pcl/sample_consensus/sac_model_perpendicular_plane.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/mapping/pcl_clouds.h"

namespace uwsim {
namespace {

/// The finite points, with shift_m subtracted.
Cloud::Ptr to_finite_cloud(std::span<const float> points_m, const Eigen::Vector3d& shift_m = Eigen::Vector3d::Zero()) {
  require(points_m.size() % 3 == 0, "points_m.size", points_m.size(), "must be rows of x, y, z");
  auto cloud = pcl::make_shared<Cloud>();
  cloud->reserve(points_m.size() / 3);
  for (std::size_t i = 0; i < points_m.size(); i += 3) {
    const Eigen::Vector3d point_m(points_m[i], points_m[i + 1], points_m[i + 2]);
    if (!point_m.allFinite()) continue;
    const Eigen::Vector3f near_m = (point_m - shift_m).cast<float>();
    cloud->emplace_back(near_m.x(), near_m.y(), near_m.z());
  }
  return cloud;
}

void require_finite_points(std::span<const float> points_m, const char* name, std::size_t least) {
  require(points_m.size() % 3 == 0, name, points_m.size(), "must be rows of x, y, z");
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (std::isfinite(points_m[i])) continue;
    require(false, std::string(name) + "[" + std::to_string(i / 3) + "]", points_m[i], "must be finite");
  }
  require(points_m.size() / 3 >= least, std::string(name) + ".size", points_m.size() / 3,
          "must be at least " + std::to_string(least) + " points");
}

/// The mean of the finite points. PCL's float32 sums lose too many digits far from the origin, so PCL's fits are done
/// relative to this point.
Eigen::Vector3d mean_m(std::span<const float> points_m) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i + 2 < points_m.size(); i += 3) {
    const Eigen::Vector3d point_m(points_m[i], points_m[i + 1], points_m[i + 2]);
    if (!point_m.allFinite()) continue;
    sum_m += point_m;
    ++count;
  }
  return sum_m / std::max(count, 1);
}

/// PCL prints failures to stderr; uwsim throws exceptions instead.
void silence_pcl() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }

}  // namespace

std::vector<float> voxel_grid(std::span<const float> points_m, double voxel_m) {
  require(std::isfinite(voxel_m) && voxel_m > 0, "voxel_m", voxel_m, "must be positive [m]");
  Eigen::Array3d low_m = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high_m = -low_m;
  const Cloud::Ptr cloud = to_finite_cloud(points_m);
  for (const pcl::PointXYZ& p : *cloud) {
    const Eigen::Array3d point_m = p.getArray3fMap().cast<double>();
    low_m = low_m.min(point_m);
    high_m = high_m.max(point_m);
  }
  if (!(low_m <= high_m).all()) return {};
  // The corner of the grid of cubes; relative to it, PCL's float32 sums lose few digits
  const Eigen::Array3d corner_m = (low_m / voxel_m).floor() * voxel_m;
  // With two extra cubes along each axis, to allow for rounding
  const double voxels = ((high_m - corner_m) / voxel_m + 2.0).prod();
  require(voxels < std::numeric_limits<std::int32_t>::max(), "voxel_m", voxel_m,
          "too small for the cloud's box, which must have fewer than 2^31 voxels");
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(Eigen::Vector4f::Constant(static_cast<float>(voxel_m)));
  grid.setInputCloud(to_finite_cloud(points_m, corner_m));
  Cloud centroids;
  grid.filter(centroids);
  std::vector<float> centroids_m = to_points(centroids);
  for (std::size_t i = 0; i < centroids_m.size(); ++i) {
    centroids_m[i] = static_cast<float>(centroids_m[i] + corner_m[static_cast<Eigen::Index>(i % 3)]);
  }
  return centroids_m;
}

std::vector<float> pass_through(std::span<const float> points_m, int axis, double min_m, double max_m) {
  require(axis >= 0 && axis <= 2, "axis", axis, "must be 0 (x), 1 (y) or 2 (z)");
  require(!std::isnan(min_m), "min_m", min_m, "must be a number [m]");
  require(max_m >= min_m, "max_m", max_m, "must be at least min_m");
  const Cloud::Ptr cloud = to_finite_cloud(points_m);
  if (cloud->empty()) return {};
  pcl::PassThrough<pcl::PointXYZ> filter;
  filter.setFilterFieldName(std::string(1, "xyz"[axis]));
  filter.setFilterLimits(static_cast<float>(min_m), static_cast<float>(max_m));
  filter.setInputCloud(cloud);
  Cloud kept;
  filter.filter(kept);
  return to_points(kept);
}

std::vector<float> remove_outliers(std::span<const float> points_m, int neighbours, double deviations) {
  require(neighbours >= 1, "neighbours", neighbours, "must be at least 1");
  require(std::isfinite(deviations) && deviations >= 0, "deviations", deviations, "must be finite and at least 0");
  const Cloud::Ptr cloud = to_finite_cloud(points_m, mean_m(points_m));
  if (cloud->empty()) return {};
  require(cloud->size() > static_cast<std::size_t>(neighbours), "neighbours", neighbours,
          "must be less than the number of points, " + std::to_string(cloud->size()));
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setMeanK(neighbours);
  filter.setStddevMulThresh(deviations);
  filter.setInputCloud(cloud);
  pcl::Indices kept;
  filter.filter(kept);
  const Cloud::Ptr unshifted = to_finite_cloud(points_m);
  return to_points(Cloud(*unshifted, kept));
}

PlaneFit ground_plane(std::span<const float> points_m, double distance_m, double max_slope_rad) {
  require(std::isfinite(distance_m) && distance_m > 0, "distance_m", distance_m, "must be positive [m]");
  require(max_slope_rad > 0 && max_slope_rad <= std::numbers::pi / 2, "max_slope_rad", max_slope_rad,
          "must be in (0, pi/2] rad");
  require_finite_points(points_m, "points_m", 3);
  silence_pcl();
  const Eigen::Vector3d mean = mean_m(points_m);
  const auto model =
      pcl::make_shared<pcl::SampleConsensusModelPerpendicularPlane<pcl::PointXYZ>>(to_finite_cloud(points_m, mean));
  model->setAxis(Eigen::Vector3f::UnitZ());
  model->setEpsAngle(max_slope_rad);
  pcl::RandomSampleConsensus<pcl::PointXYZ> search(model, distance_m);
  pcl::Indices inliers;
  Eigen::VectorXf found;
  if (search.computeModel()) {
    search.getInliers(inliers);
    search.getModelCoefficients(found);
  }
  require(inliers.size() >= 3, "points_m", points_m.size() / 3, "must have three points on a plane of max_slope_rad");
  Eigen::VectorXf fitted;
  model->optimizeModelCoefficients(inliers, found, fitted);
  model->selectWithinDistance(fitted, distance_m, inliers);

  PlaneFit plane{fitted.head<3>().cast<double>(), fitted[3], std::vector<std::uint8_t>(points_m.size() / 3, 0)};
  const double length = plane.normal.norm() * (plane.normal.z() < 0 ? -1.0 : 1.0);
  plane.normal /= length;
  plane.offset_m = plane.offset_m / length - plane.normal.dot(mean);
  for (const pcl::index_t i : inliers) plane.inliers[static_cast<std::size_t>(i)] = 1;
  return plane;
}

}  // namespace uwsim
