#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <span>
#include <vector>

/// Rows of x, y, z and PCL's clouds. Only the files that implement clouds.h include this.
namespace uwsim {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr to_cloud(std::span<const float> points_m);
std::vector<float> to_points(const Cloud& cloud);
void require_rigid(const Eigen::Matrix4d& transform);

}  // namespace uwsim
