#include "uwsim/vehicle/panel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace uwsim {

Panel::Panel(const std::array<Eigen::Vector3d, 3>& corners_m) : corners_m_(corners_m) {
  const Eigen::Vector3d doubled = (corners_m[1] - corners_m[0]).cross(corners_m[2] - corners_m[0]);
  area_m2_ = 0.5 * doubled.norm();
  normal_ = doubled.normalized();
  middle_m_ = (corners_m[0] + corners_m[1] + corners_m[2]) / 3;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d edge = corners_m[(k + 1) % 3] - corners_m[k];
    edges_m_[k] = edge.norm();
    along_[k] = edge / edges_m_[k];
    outward_[k] = along_[k].cross(normal_);
    points_m_[k] = 0.5 * (middle_m_ + corners_m[k]);
    radius_m_ = std::max(radius_m_, (corners_m[k] - middle_m_).norm());
  }
}

Panel::Seen Panel::seen_from(const Eigen::Vector3d& point_m, bool in_plane) const {
  std::array<Eigen::Vector3d, 3> to;
  std::array<double, 3> lengths_m;
  for (int k = 0; k < 3; ++k) {
    to[k] = corners_m_[k] - point_m;
    lengths_m[k] = to[k].norm();
  }
  const double height_m = in_plane ? 0 : to[0].dot(normal_);
  const double spread = lengths_m[0] * lengths_m[1] * lengths_m[2] + to[0].dot(to[1]) * lengths_m[2] +
                        to[1].dot(to[2]) * lengths_m[0] + to[2].dot(to[0]) * lengths_m[1];
  const double angle = in_plane ? 0 : 2 * std::atan2(2 * area_m2_ * height_m, spread);
  Seen seen;
  seen.sources_m = -height_m * angle;
  std::array<double, 3> rims_m;
  Eigen::Vector3d around = Eigen::Vector3d::Zero();  // the integral of 1/r around the rim, times the outward direction
  for (int k = 0; k < 3; ++k) {
    const double total_m = lengths_m[k] + lengths_m[(k + 1) % 3];
    // ln of (r1 + r2 + edge) / (r1 + r2 - edge), which is Wilton's logarithm without its cancellation
    const double logarithm = std::log((total_m + edges_m_[k]) / std::max(total_m - edges_m_[k], 1e-300));
    rims_m[k] = to[k].dot(outward_[k]);
    around += logarithm * outward_[k];
    seen.sources_m += rims_m[k] * logarithm;
    const double ends_m2 =
        to[(k + 1) % 3].dot(along_[k]) * lengths_m[(k + 1) % 3] - to[k].dot(along_[k]) * lengths_m[k];
    seen.moment_m2 += 0.5 * (ends_m2 + (rims_m[k] * rims_m[k] + height_m * height_m) * logarithm) * outward_[k];
  }
  for (int k = 0; k < 3; ++k) {
    const int facing = (k + 1) % 3;                          // the edge that does not touch corner k
    const double slope = edges_m_[facing] / (2 * area_m2_);  // of the hat, away from that edge
    seen.dipoles(k) = -slope * (rims_m[facing] * angle + height_m * outward_[facing].dot(around));
  }
  return seen;
}

}  // namespace uwsim
