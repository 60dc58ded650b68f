#include <pcl/common/transforms.h>
#include <pcl/filters/crop_box.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/mapping/clouds.h"
#include "uwsim/mapping/pcl_clouds.h"

namespace uwsim {
namespace {

/// The cosines and sines of a scan's beams. All scans of a sonar have the same beams, so the thread's last are kept:
/// computing them takes most of the time of a conversion.
struct BeamTable {
  double angle_min_rad = 0, angle_increment_rad = 0;
  std::vector<Eigen::Vector2d> directions;

  static const BeamTable& of(const ScanGeometry& geometry, std::size_t beams) {
    thread_local BeamTable table;
    if (table.directions.size() != beams || table.angle_min_rad != geometry.angle_min_rad ||
        table.angle_increment_rad != geometry.angle_increment_rad) {
      table = {geometry.angle_min_rad, geometry.angle_increment_rad, {}};
      for (std::size_t beam = 0; beam < beams; ++beam) {
        const double angle_rad = geometry.angle_min_rad + static_cast<double>(beam) * geometry.angle_increment_rad;
        table.directions.emplace_back(std::cos(angle_rad), std::sin(angle_rad));
      }
    }
    return table;
  }
};

Cloud::Ptr cloud_of_scan(std::span<const float> ranges_m, const ScanGeometry& geometry) {
  require(std::isfinite(geometry.angle_min_rad), "scan.angle_min", geometry.angle_min_rad, "must be finite");
  require(std::isfinite(geometry.angle_increment_rad), "scan.angle_increment", geometry.angle_increment_rad,
          "must be finite");
  require(geometry.range_min_m >= 0, "scan.range_min", geometry.range_min_m, "must be at least 0 m");
  require(geometry.range_max_m > geometry.range_min_m, "scan.range_max", geometry.range_max_m,
          "must be greater than range_min");
  const BeamTable& table = BeamTable::of(geometry, ranges_m.size());
  auto cloud = pcl::make_shared<Cloud>();
  cloud->reserve(ranges_m.size());
  for (std::size_t beam = 0; beam < ranges_m.size(); ++beam) {
    const double range_m = ranges_m[beam];
    if (!(range_m >= geometry.range_min_m && range_m < geometry.range_max_m)) continue;
    const Eigen::Vector2f point_m = (range_m * table.directions[beam]).cast<float>();
    cloud->emplace_back(point_m.x(), point_m.y(), 0.0f);
  }
  return cloud;
}

/// Transforms a cloud in place. PCL computes in double and rounds each point once.
void transform(Cloud& cloud, const Eigen::Matrix4d& target_from_source) {
  require_rigid(target_from_source);
  if (!cloud.empty()) pcl::transformPointCloud(cloud, cloud, target_from_source);  // of none, PCL prints a warning
}

void keep_in_range(Cloud& cloud, double min_m, double max_m) {
  require(min_m >= 0, "min_m", min_m, "must be at least 0 m");
  require(max_m >= min_m, "max_m", max_m, "must be at least min_m");
  const auto is_beyond = [&](const pcl::PointXYZ& p) {
    const double distance_m = Eigen::Vector3d(p.x, p.y, p.z).norm();
    return !(distance_m >= min_m && distance_m <= max_m);
  };
  cloud.erase(std::remove_if(cloud.begin(), cloud.end(), is_beyond), cloud.end());
}

Cloud outside_box(const Cloud::Ptr& cloud, const Eigen::Vector3d& box_min_m, const Eigen::Vector3d& box_max_m) {
  require(box_min_m.allFinite() && box_max_m.allFinite() && (box_min_m.array() <= box_max_m.array()).all(), "box_max_m",
          box_max_m.transpose(), "must be finite and at least box_min_m along each axis");
  Cloud outside;
  if (cloud->empty()) return outside;
  pcl::CropBox<pcl::PointXYZ> crop;
  crop.setMin((Eigen::Vector4f() << box_min_m.cast<float>(), 1.0f).finished());
  crop.setMax((Eigen::Vector4f() << box_max_m.cast<float>(), 1.0f).finished());
  crop.setNegative(true);
  crop.setInputCloud(cloud);
  crop.filter(outside);
  return outside;
}

}  // namespace

Cloud::Ptr to_cloud(std::span<const float> points_m) {
  require(points_m.size() % 3 == 0, "points_m.size", points_m.size(), "must be rows of x, y, z");
  auto cloud = pcl::make_shared<Cloud>(static_cast<std::uint32_t>(points_m.size() / 3), 1);
  const float* from = points_m.data();
  for (pcl::PointXYZ& p : *cloud) {
    p = {from[0], from[1], from[2]};
    from += 3;
  }
  cloud->is_dense = std::ranges::all_of(points_m, [](float value) { return std::isfinite(value); });
  return cloud;
}

std::vector<float> to_points(const Cloud& cloud) {
  std::vector<float> points_m(3 * cloud.size());
  float* to = points_m.data();
  for (const pcl::PointXYZ& p : cloud) {
    to[0] = p.x, to[1] = p.y, to[2] = p.z;
    to += 3;
  }
  return points_m;
}

void require_rigid(const Eigen::Matrix4d& transform) {
  const Eigen::Matrix3d rotation = transform.topLeftCorner<3, 3>();
  const bool rigid = transform.allFinite() && transform.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9) &&
                     (rotation * rotation.transpose()).isIdentity(1e-6) && rotation.determinant() > 0;
  if (rigid) return;
  std::ostringstream matrix;
  matrix << transform.format({4, 0, ", ", "; ", "", "", "[", "]"});
  require(false, "target_from_source", matrix.str(),
          "must be a rigid transform (a rotation, a translation and the row 0 0 0 1)");
}

std::vector<float> scan_to_points(std::span<const float> ranges_m, const ScanGeometry& geometry) {
  return to_points(*cloud_of_scan(ranges_m, geometry));
}

std::vector<float> transform_points(std::span<const float> points_source_m, const Eigen::Matrix4d& target_from_source) {
  const Cloud::Ptr cloud = to_cloud(points_source_m);
  transform(*cloud, target_from_source);
  return to_points(*cloud);
}

Eigen::Matrix4d relative_transform(const Eigen::Matrix4d& world_from_target, const Eigen::Matrix4d& world_from_source) {
  return Eigen::Isometry3d(world_from_target).inverse().matrix() * world_from_source;
}

std::vector<float> filter_range(std::span<const float> points_m, double min_m, double max_m) {
  const Cloud::Ptr cloud = to_cloud(points_m);
  keep_in_range(*cloud, min_m, max_m);
  return to_points(*cloud);
}

std::vector<float> remove_box(std::span<const float> points_m, const Eigen::Vector3d& box_min_m,
                              const Eigen::Vector3d& box_max_m) {
  return to_points(outside_box(to_cloud(points_m), box_min_m, box_max_m));
}

std::vector<float> scan_to_world(std::span<const float> ranges_m, const ScanGeometry& geometry,
                                 const Eigen::Vector3d& box_min_m, const Eigen::Vector3d& box_max_m,
                                 const Eigen::Matrix4d& world_from_body, const Eigen::Matrix4d& world_from_sonar) {
  const Cloud::Ptr cloud = cloud_of_scan(ranges_m, geometry);
  keep_in_range(*cloud, geometry.range_min_m, geometry.range_max_m);
  transform(*cloud, relative_transform(world_from_body, world_from_sonar));
  Cloud echoes = outside_box(cloud, box_min_m, box_max_m);
  transform(echoes, world_from_body);
  return to_points(echoes);
}

}  // namespace uwsim
