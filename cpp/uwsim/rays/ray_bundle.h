#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "uwsim/rays/moving_bodies.h"
#include "uwsim/rays/ray_lanes.h"

namespace uwsim {

/// A cone around rays, such as the active ones of a packet, for quickly deciding whether any of them may reach a
/// sphere. The test is conservative: the answer is never "no" if a ray does reach the sphere.
class RayBundle {
 public:
  /// `anchor_world_m`: the reference point of the packet's origins. `distance_m`: the distance of each ray's nearest
  /// hit so far; anything behind it is irrelevant.
  template <typename Packet, typename Distances>
  RayBundle(const Eigen::Vector3d& anchor_world_m, const Packet& rays, const Distances& distance_m) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t first = kPacketRays;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (rays.active[k] == 0) continue;
      first = std::min(first, k);
      sum += direction_of(rays, k).template cast<double>();
      far_m_ = std::max(far_m_, static_cast<double>(std::min(rays.far_m[k], distance_m[k])));
    }
    if (first == kPacketRays) return;
    const Eigen::Vector3d apex = origin_of(rays, first).template cast<double>();
    const double length = sum.norm();
    if (length > 0) axis_ = sum / length;
    double spread2 = 0;
    cosine_ = length > 0 ? 1 : -1;
    for (std::size_t k = first; k < kPacketRays; ++k) {
      if (rays.active[k] == 0) continue;
      spread2 = std::max(spread2, (origin_of(rays, k).template cast<double>() - apex).squaredNorm());
      cosine_ = std::min(cosine_, axis_.dot(direction_of(rays, k).template cast<double>()));
    }
    apex_world_m_ = anchor_world_m + apex;
    spread_m_ = std::sqrt(spread2);
    cosine_ -= kRounding;
    sine_ = std::sqrt(std::max(0.0, 1 - cosine_ * cosine_));
  }

  explicit RayBundle(const RayCone& cone)
      : apex_world_m_(cone.apex_world_m),
        axis_(cone.axis_world),
        cosine_(cone.cosine - kRounding),
        sine_(std::sqrt(std::max(0.0, 1 - cosine_ * cosine_))),
        far_m_(cone.length_m) {}

  bool may_reach(const Eigen::Vector3d& centre_world_m, double radius_m) const {
    const double radius = radius_m + spread_m_;
    const Eigen::Vector3d to_centre = centre_world_m - apex_world_m_;
    const double distance2 = to_centre.squaredNorm(), reach = far_m_ + radius;
    if (!(reach >= 0 && distance2 <= reach * reach)) return false;
    if (cosine_ <= 0) return true;
    // The distance from the sphere's centre to the cone's side, extended to a line, in the plane that contains the axis
    // and the centre.
    const double along = to_centre.dot(axis_);
    const double aside = std::sqrt(std::max(0.0, distance2 - along * along));
    return aside * cosine_ - along * sine_ <= radius * (1 + kRounding) + kRounding * std::abs(along);
  }

 private:
  static constexpr double kRounding = 1e-7;  // of float: directions are unit vectors to within 6e-8

  Eigen::Vector3d apex_world_m_ = Eigen::Vector3d::Zero(), axis_ = Eigen::Vector3d::Zero();
  double spread_m_ = 0;  // largest distance of an origin from the apex
  double cosine_ = -1, sine_ = 0;
  double far_m_ = -std::numeric_limits<double>::infinity();
};

}  // namespace uwsim
