#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "uwsim/core/infinity.h"
#include "uwsim/rays/cover_trees.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/tolerances.h"

namespace uwsim {

/// Sixteen rays on their way through the tiles: lanes end at their nearest hit so far.
struct CoverTrees::Walk {
  using Lanes = std::array<double, kPacketRays>;
  Lanes origin[3], direction[3], inverse[3], near_m, far_m;
  std::array<std::int32_t, kPacketRays> active;

  template <typename Rays, typename Far>
  Walk(const Eigen::Vector3d& anchor_world_m, const Rays& rays, const Far& end_m) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Eigen::Vector3d from = anchor_world_m + origin_of(rays, k).template cast<double>();
      const Eigen::Vector3d along = direction_of(rays, k).template cast<double>();
      const bool idle = rays.active[k] == 0 || !from.allFinite() || !along.allFinite();
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        origin[a][k] = idle ? 0 : from(axis);
        direction[a][k] = idle ? (axis == 2 ? 1 : 0) : along(axis);
        inverse[a][k] = 1 / direction[a][k];
      }
      near_m[k] = 0;
      far_m[k] = std::min<double>(rays.far_m[k], end_m[k]);
      active[k] = idle ? 0 : -1;
    }
  }

  /// Sets first_m to where each lane enters a box before its end, or to infinity; returns the least of them.
  double enter(const Eigen::AlignedBox3d& box, Lanes& first_m) const {
    static const RayKernels& kernels = ray_kernels();
    const LaneSlabs slabs{{origin[0].data(), origin[1].data(), origin[2].data()},
                          {inverse[0].data(), inverse[1].data(), inverse[2].data()},
                          near_m.data(),
                          far_m.data(),
                          active.data()};
    return kernels.enter_box(slabs, box.min().data(), box.max().data(), first_m.data());
  }

  /// Bounds of all active lanes, for a quick test of them at once.
  struct Bounds {
    struct Axis {
      double first_origin = kInfinity, last_origin = -kInfinity, least_inverse = kInfinity, most_inverse = -kInfinity;
    };
    Axis axes[3];
    double near_m = kInfinity, far_m = -kInfinity;

    /// No lane enters a box before this; infinity if none does. Differences and products are monotonic, rounded as
    /// well, so that no lane for which Walk::enter finds a way is left out.
    double enter(const Eigen::AlignedBox3d& box) const {
      double first = near_m, last = far_m;
      for (int k = 0; k < 3; ++k) {
        const Axis& axis = axes[k];
        const bool ahead = axis.least_inverse > 0;
        if (!ahead && !(axis.most_inverse < 0)) continue;  // lanes of both signs
        if (axis.least_inverse == -kInfinity || axis.most_inverse == kInfinity) continue;
        // The least way to the nearer side and the greatest to the farther side.
        const double in = ahead ? box.min()(k) - axis.last_origin : box.max()(k) - axis.first_origin;
        const double out = ahead ? box.max()(k) - axis.first_origin : box.min()(k) - axis.last_origin;
        first = std::max(first, in * (in > 0 ? axis.least_inverse : axis.most_inverse));
        last = std::min(last, out * (out > 0 ? axis.most_inverse : axis.least_inverse));
      }
      return first <= last ? first : kInfinity;
    }
  };
  Bounds bounds() const {
    Bounds all;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (active[k] == 0) continue;
      all.near_m = std::min(all.near_m, near_m[k]), all.far_m = std::max(all.far_m, far_m[k]);
      for (std::size_t a = 0; a < 3; ++a) {
        Bounds::Axis& axis = all.axes[a];
        axis.first_origin = std::min(axis.first_origin, origin[a][k]);
        axis.last_origin = std::max(axis.last_origin, origin[a][k]);
        axis.least_inverse = std::min(axis.least_inverse, inverse[a][k]);
        axis.most_inverse = std::max(axis.most_inverse, inverse[a][k]);
      }
    }
    return all;
  }

  /// The least and the greatest x of the lanes within a strip from south to north, each between its own limits.
  std::pair<double, double> across(std::pair<double, double> south_and_north, const Lanes& first_m,
                                   const Lanes& last_m) const {
    double west = kInfinity, east = -kInfinity;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (active[k] == 0) continue;
      double from = first_m[k], to = last_m[k];
      if (direction[1][k] != 0) {
        const double one = (south_and_north.first - origin[1][k]) * inverse[1][k],
                     two = (south_and_north.second - origin[1][k]) * inverse[1][k];
        from = std::max(from, std::min(one, two)), to = std::min(to, std::max(one, two));
      }
      if (from > to) continue;
      const double one = origin[0][k] + from * direction[0][k], two = origin[0][k] + to * direction[0][k];
      west = std::min({west, one, two}), east = std::max({east, one, two});
    }
    return {west, east};
  }

  /// Where a lane that enters a box leaves it, or ends.
  double exit(std::size_t k, const Eigen::AlignedBox3d& box) const {
    double last = far_m[k];
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double one = (box.min()(axis) - origin[a][k]) * inverse[a][k];
      const double two = (box.max()(axis) - origin[a][k]) * inverse[a][k];
      last = std::min(last, std::max(one, two));
    }
    return last;
  }
};

/// Fills Embree's rays, relative to a tile's middle; idle lanes stay finite.
template <typename Walk>
void fill(const Walk& walk, const Eigen::Vector3d& middle_m, const std::array<std::int32_t, kPacketRays>& lanes,
          RTCRay16& ray) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const bool idle = lanes[k] == 0;
    ray.org_x[k] = idle ? 0 : static_cast<float>(walk.origin[0][k] - middle_m.x());
    ray.org_y[k] = idle ? 0 : static_cast<float>(walk.origin[1][k] - middle_m.y());
    ray.org_z[k] = idle ? 0 : static_cast<float>(walk.origin[2][k] - middle_m.z());
    ray.dir_x[k] = static_cast<float>(walk.direction[0][k]);
    ray.dir_y[k] = static_cast<float>(walk.direction[1][k]);
    ray.dir_z[k] = static_cast<float>(walk.direction[2][k]);
    ray.tnear[k] = idle ? 0 : static_cast<float>(walk.near_m[k]);
    ray.tfar[k] = idle ? 0 : static_cast<float>(std::min(walk.far_m[k], 1e6));
    ray.time[k] = 0;
    ray.mask[k] = ~0u;
    ray.id[k] = static_cast<unsigned>(k);
    ray.flags[k] = 0;
  }
}

/// Some of a tile's pieces as the target of a cast.
struct CoverTarget {
  const CoverTile& tile;
  RTCScene tree;
  std::span<const Lean> leans;
};

/// Embree's hits on the pieces of a tile.
template <typename Walk>
RTCRayHit16 met(const CoverTarget& target, const Walk& walk, const std::array<std::int32_t, kPacketRays>& lanes) {
  RTCRayHit16 packet;
  fill(walk, target.tile.middle_m(), lanes, packet.ray);
  std::ranges::fill(packet.hit.geomID, RTC_INVALID_GEOMETRY_ID);
  std::ranges::fill(packet.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  intersect(target.tree, {}, RayOrder::kIncoherent, lanes.data(), packet);
  return packet;
}

/// A hit on a piece, computed in double on the triangle that Embree found.
struct PieceHit {
  double distance_m, u, v;
  Eigen::Vector3d normal;
};

inline PieceHit solve(const Corners& corners, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      double embree_m) {
  const Eigen::Vector3d ab = corners[1] - corners[0], ac = corners[2] - corners[0], normal = ab.cross(ac);
  const double area = normal.norm(), along = normal.dot(direction);
  PieceHit hit{embree_m, 0, 0, area > 0 ? Eigen::Vector3d(normal / area) : Eigen::Vector3d::UnitZ()};
  // Closer to tangency, the plane determines the distance less accurately than Embree does.
  if (std::abs(along) < kGrazingSine * area || area == 0) return hit;
  const Eigen::Vector3d to_a = corners[0] - origin, moment = to_a.cross(direction);
  hit.distance_m = std::max(0.0, normal.dot(to_a) / along);
  hit.u = ac.dot(moment) / along, hit.v = -ab.dot(moment) / along;
  return hit;
}

}  // namespace uwsim
