#include "uwsim/rays/visibility.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "uwsim/core/parallel.h"
#include "uwsim/rays/ray_lanes.h"

namespace uwsim {
namespace {

constexpr std::size_t kGroupsTogether = 64;  // number of groups that share a list of nearest viewpoints
// Near viewpoints are searched among every eighth viewpoint, since neighbours on a path have similar views.
constexpr std::size_t kViewpointStride = 8;
constexpr std::size_t kNearViewpoints = 24;  // number of viewpoints that are tried before all others

/// Collects rays from viewpoints to points, and casts sixteen at a time.
class SightLines {
 public:
  SightLines(const RayScene& scene, double tolerance_m, std::span<std::uint8_t> seen)
      : scene_(scene), tolerance_m_(tolerance_m), seen_(seen) {}

  void add(std::size_t group, const Eigen::Vector3d& viewpoint, const Eigen::Vector3d& point) {
    const Eigen::Vector3d to_point = point - viewpoint;
    distances_m_[count_] = to_point.norm();
    const Eigen::Vector3d direction =
        to_point.isZero(0) ? Eigen::Vector3d::UnitZ().eval() : to_point.stableNormalized().eval();
    set_ray(rays_, count_, viewpoint, direction, std::numeric_limits<float>::max(), true);
    groups_[count_] = group;
    if (++count_ == kPacketRays) cast();
  }

  /// Casts the collected rays, and marks the groups that are visible.
  void cast() {
    if (count_ == 0) return;
    for (std::size_t k = count_; k < kPacketRays; ++k) {
      set_ray(rays_, k, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0, false);
    }
    ExactHits hits;
    scene_.cast(std::span<const ExactRays>(&rays_, 1), std::span<ExactHits>(&hits, 1));
    for (std::size_t k = 0; k < count_; ++k) {
      if (hits.distance_m[k] + tolerance_m_ >= distances_m_[k]) seen_[groups_[k]] = 1;
    }
    count_ = 0;
  }

 private:
  const RayScene& scene_;
  double tolerance_m_;
  std::span<std::uint8_t> seen_;
  ExactRays rays_;
  std::array<std::size_t, kPacketRays> groups_;
  std::array<double, kPacketRays> distances_m_;
  std::size_t count_ = 0;
};

/// One thread's search; the vectors are scratch memory.
class ViewSearch {
 public:
  ViewSearch(const RayScene& scene, std::span<const Eigen::Vector3d> viewpoints, const PointGroups& groups,
             double range_m, double tolerance_m, bool all_outside, std::span<std::uint8_t> seen)
      : scene_(scene),
        viewpoints_(viewpoints),
        groups_(groups),
        range_m_(range_m),
        tolerance_m_(tolerance_m),
        all_outside_(all_outside),
        seen_(seen),
        lines_(scene, tolerance_m, seen) {}

  void look_at(std::size_t first, std::size_t last) {
    while (first < last && groups_.points(first).empty()) ++first;
    if (first == last) return;
    find_near_viewpoints(groups_.points(first).front());
    try_near_viewpoints(first, last);
    for (std::size_t group = first; group < last; ++group) {
      if (seen_[group] == 0) try_all_viewpoints(group);
    }
  }

 private:
  bool in_range(std::size_t viewpoint, const Eigen::Vector3d& point) const {
    return (point - viewpoints_[viewpoint]).squaredNorm() <= range_m_ * range_m_;
  }

  /// Finds viewpoints near a point, nearest first.
  void find_near_viewpoints(const Eigen::Vector3d& place) {
    near_.clear();
    for (std::size_t k = 0; k < viewpoints_.size(); k += kViewpointStride) {
      near_.emplace_back((viewpoints_[k] - place).squaredNorm(), k);
    }
    const auto middle = near_.begin() + static_cast<std::ptrdiff_t>(std::min(kNearViewpoints, near_.size()));
    std::partial_sort(near_.begin(), middle, near_.end());
    near_.erase(middle, near_.end());
  }

  void try_near_viewpoints(std::size_t first, std::size_t last) {
    for (std::size_t turn = 0; turn < near_.size(); ++turn) {
      const std::size_t viewpoint = near_[turn].second;
      for (std::size_t group = first; group < last; ++group) {
        const auto points = groups_.points(group);
        if (seen_[group] != 0 || points.empty()) continue;
        const Eigen::Vector3d& point = points[turn % points.size()];
        if (in_range(viewpoint, point)) lines_.add(group, viewpoints_[viewpoint], point);
      }
      lines_.cast();
    }
  }

  void try_all_viewpoints(std::size_t group) {
    for (const Eigen::Vector3d& point : groups_.points(group)) {
      if (all_outside_ && scene_.within_round(point, tolerance_m_)) continue;
      for (std::size_t k = 0; k < viewpoints_.size() && seen_[group] == 0; ++k) {
        if (in_range(k, point)) lines_.add(group, viewpoints_[k], point);
      }
      lines_.cast();
    }
  }

  const RayScene& scene_;
  std::span<const Eigen::Vector3d> viewpoints_;
  const PointGroups& groups_;
  double range_m_, tolerance_m_;
  bool all_outside_;  // whether no viewpoint is inside a round shape
  std::span<std::uint8_t> seen_;
  SightLines lines_;
  std::vector<std::pair<double, std::size_t>> near_;  // squared distance and index of viewpoints
};

}  // namespace

std::vector<std::uint8_t> seen_groups(const RayScene& scene, std::span<const Eigen::Vector3d> viewpoints_world_m,
                                      const PointGroups& groups, double range_m, double tolerance_m, int threads) {
  std::vector<std::uint8_t> seen(groups.count(), 0);
  if (viewpoints_world_m.empty()) return seen;
  const bool all_outside = std::ranges::none_of(
      viewpoints_world_m, [&](const Eigen::Vector3d& viewpoint) { return scene.within_round(viewpoint, 0); });
  parallel_batches(groups.count(), kGroupsTogether, threads, [&](std::size_t first, std::size_t last, std::size_t) {
    ViewSearch(scene, viewpoints_world_m, groups, range_m, tolerance_m, all_outside, seen).look_at(first, last);
  });
  return seen;
}

}  // namespace uwsim
