#include "uwsim/mapping/clouds.h"

#include <pcl/common/transforms.h>
#include <pcl/filters/crop_box.h>
#include <pcl/filters/experimental/functor_filter.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/LU>
#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr to_cloud(std::span<const float> points_m) {
  require(points_m.size() % 3 == 0, "points_m.size", points_m.size(), "must be rows of x, y, z");
  auto cloud = pcl::make_shared<Cloud>();
  cloud->reserve(points_m.size() / 3);
  for (std::size_t i = 0; i < points_m.size(); i += 3) {
    cloud->emplace_back(points_m[i], points_m[i + 1], points_m[i + 2]);
    cloud->is_dense = cloud->is_dense && pcl::isFinite(cloud->back());
  }
  return cloud;
}

std::vector<float> to_points(const Cloud& cloud) {
  std::vector<float> points_m;
  points_m.reserve(3 * cloud.size());
  for (const pcl::PointXYZ& p : cloud) points_m.insert(points_m.end(), {p.x, p.y, p.z});
  return points_m;
}

void require_rigid(const Eigen::Matrix4d& transform) {
  const Eigen::Matrix3d rotation = transform.topLeftCorner<3, 3>();
  const bool rigid = transform.allFinite() && transform.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9) &&
                     (rotation * rotation.transpose()).isIdentity(1e-6) && rotation.determinant() > 0;
  require(rigid, "target_from_source", transform.format({4, 0, ", ", "; ", "", "", "[", "]"}),
          "must be a rigid transform (a rotation, a translation and the row 0 0 0 1)");
}

}  // namespace

std::vector<float> scan_to_points(std::span<const float> ranges_m, const ScanGeometry& geometry) {
  require(std::isfinite(geometry.angle_min_rad), "scan.angle_min", geometry.angle_min_rad, "must be finite");
  require(std::isfinite(geometry.angle_increment_rad), "scan.angle_increment", geometry.angle_increment_rad,
          "must be finite");
  require(geometry.range_min_m >= 0, "scan.range_min", geometry.range_min_m, "must be at least 0 m");
  require(geometry.range_max_m > geometry.range_min_m, "scan.range_max", geometry.range_max_m,
          "must be greater than range_min");
  Cloud cloud;
  cloud.reserve(ranges_m.size());
  for (std::size_t beam = 0; beam < ranges_m.size(); ++beam) {
    const double range_m = ranges_m[beam];
    if (!(range_m >= geometry.range_min_m && range_m < geometry.range_max_m)) continue;
    const double angle_rad = geometry.angle_min_rad + static_cast<double>(beam) * geometry.angle_increment_rad;
    cloud.emplace_back(static_cast<float>(range_m * std::cos(angle_rad)),
                       static_cast<float>(range_m * std::sin(angle_rad)), 0.0f);
  }
  return to_points(cloud);
}

std::vector<float> transform_points(std::span<const float> points_source_m, const Eigen::Matrix4d& target_from_source) {
  require_rigid(target_from_source);
  if (points_source_m.empty()) return {};  // which PCL would grumble about on stderr
  const Cloud::Ptr source = to_cloud(points_source_m);
  Cloud target;
  pcl::transformPointCloud(*source, target, target_from_source);  // reckons in double, rounds each point once
  return to_points(target);
}

std::vector<float> filter_range(std::span<const float> points_m, double min_m, double max_m) {
  require(min_m >= 0, "min_m", min_m, "must be at least 0 m");
  require(max_m >= min_m, "max_m", max_m, "must be at least min_m");
  if (points_m.empty()) return {};
  pcl::experimental::FunctionFilter<pcl::PointXYZ> filter([=](const Cloud& cloud, pcl::index_t index) {
    const double distance_m = cloud[static_cast<std::size_t>(index)].getVector3fMap().cast<double>().norm();
    return distance_m >= min_m && distance_m <= max_m;
  });
  filter.setInputCloud(to_cloud(points_m));
  Cloud kept;
  filter.filter(kept);
  return to_points(kept);
}

std::vector<float> remove_box(std::span<const float> points_m, const Eigen::Vector3d& box_min_m,
                              const Eigen::Vector3d& box_max_m) {
  require(box_min_m.allFinite() && box_max_m.allFinite() && (box_min_m.array() <= box_max_m.array()).all(), "box_max_m",
          box_max_m.transpose(), "must be finite and at least box_min_m along each axis");
  if (points_m.empty()) return {};
  pcl::CropBox<pcl::PointXYZ> crop;
  crop.setMin((Eigen::Vector4f() << box_min_m.cast<float>(), 1.0f).finished());
  crop.setMax((Eigen::Vector4f() << box_max_m.cast<float>(), 1.0f).finished());
  crop.setNegative(true);
  crop.setInputCloud(to_cloud(points_m));
  Cloud kept;
  crop.filter(kept);
  return to_points(kept);
}

}  // namespace uwsim
