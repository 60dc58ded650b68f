#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <type_traits>

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
    static_assert(offsetof(Packet, direction_z) == 5 * sizeof(typename Packet::Lanes));
    static const RayKernels& kernels = ray_kernels();
    LaneBundle bundle;
    if constexpr (std::is_same_v<Packet, RayPacket>) {
      bundle = kernels.bundle_floats(rays.origin_x.data(), rays.far_m.data(), distance_m.data(), rays.active.data());
    } else {
      bundle = kernels.bundle_doubles(rays.origin_x.data(), rays.far_m.data(), distance_m.data(), rays.active.data());
    }
    const auto first =
        static_cast<std::size_t>(std::ranges::find_if(rays.active, std::identity()) - rays.active.begin());
    if (first == kPacketRays) return;
    apex_world_m_ = anchor_world_m + origin_of(rays, first);
    axis_ = Eigen::Map<const Eigen::Vector3d>(bundle.axis);
    spread_m_ = std::sqrt(bundle.spread2);
    cosine_ = bundle.cosine - kRounding;
    sine_ = std::sqrt(std::max(0.0, 1 - cosine_ * cosine_));
    far_m_ = bundle.far_m;
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
