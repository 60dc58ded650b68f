#include "uwsim/world/ray_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/world/ray_geometry.h"
#include "uwsim/world/ray_tile.h"
#include "uwsim/world/tiling.h"

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where the ray enters the box, 0 from inside; infinity where it misses it (or is not a number).
double entry_m(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& way,
               double far_m) {
  double first = 0, last = far_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double to_low = box.min()(axis) - origin(axis), to_high = box.max()(axis) - origin(axis);
    if (way(axis) == 0) {
      if (!(to_low <= 0 && to_high >= 0)) return kInfinity;
      continue;
    }
    const double one = to_low / way(axis), two = to_high / way(axis);
    if (!(std::isfinite(one) && std::isfinite(two))) return kInfinity;
    first = std::max(first, std::min(one, two));
    last = std::min(last, std::max(one, two));
  }
  return first <= last ? first : kInfinity;
}

/// A tile that some rays of a packet reach, and where each enters it.
struct Reached {
  const RayTile* tile;
  double soonest_m;
  alignas(64) std::array<double, kPacketRays> start_m;
};

Eigen::Vector3d origin_of(const ExactRays& rays, std::size_t k) {
  return {rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]};
}

Eigen::Vector3d way_of(const ExactRays& rays, std::size_t k) {
  return {rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]};
}

void set_ray(ExactRays& rays, std::size_t k, const Eigen::Vector3d& origin, const Eigen::Vector3d& way, double far_m,
             bool active) {
  rays.origin_x[k] = origin.x();
  rays.origin_y[k] = origin.y();
  rays.origin_z[k] = origin.z();
  rays.direction_x[k] = way.x();
  rays.direction_y[k] = way.y();
  rays.direction_z[k] = way.z();
  rays.far_m[k] = far_m;
  rays.active[k] = active ? -1 : 0;
}

void copy_lane(const ExactHits& from, ExactHits& to, std::size_t k) {
  to.distance_m[k] = from.distance_m[k];
  to.normal_x[k] = from.normal_x[k];
  to.normal_y[k] = from.normal_y[k];
  to.normal_z[k] = from.normal_z[k];
  to.label[k] = from.label[k];
}

void copy_lane(const HitPacket& from, HitPacket& to, std::size_t k) {
  to.distance_m[k] = from.distance_m[k];
  to.u[k] = from.u[k];
  to.v[k] = from.v[k];
  to.normal_x[k] = from.normal_x[k];
  to.normal_y[k] = from.normal_y[k];
  to.normal_z[k] = from.normal_z[k];
  to.label[k] = from.label[k];
  to.primitive[k] = from.primitive[k];
}

ExactRays exact(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays) {
  ExactRays out;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3d origin(rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]);
    const Eigen::Vector3d way(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
    set_ray(out, k, anchor_world_m + origin, way, rays.far_m[k], rays.active[k] != 0);
  }
  return out;
}

}  // namespace

struct RayScene::Impl {
  RayDevice device = make_ray_device();
  std::vector<RayTile> tiles;
  std::shared_ptr<const Heightfield> terrain;

  explicit Impl(const World& world) : terrain(world.terrain()) {
    for (TileContents& contents : cut_into_tiles(world)) tiles.emplace_back(device.get(), world, std::move(contents));
  }

  /// The usual case: nothing to choose and nothing to move.
  const RayTile* only_tile(std::span<const ExactRays> rays) const {
    return tiles.size() == 1 && tiles.front().is_near(rays) ? &tiles.front() : nullptr;
  }

  const RayTile* only_tile(const Eigen::Vector3d& anchor_world_m) const {
    return tiles.size() == 1 && tiles.front().is_near(anchor_world_m) ? &tiles.front() : nullptr;
  }

  /// The tiles that rays reach, the soonest first.
  std::vector<Reached> reached(const ExactRays& rays) const {
    Eigen::AlignedBox3d swept;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Eigen::Vector3d end = origin_of(rays, k) + std::min(rays.far_m[k], 1e12) * way_of(rays, k);
      if (rays.active[k] == 0 || !end.allFinite()) continue;
      swept.extend(origin_of(rays, k)).extend(end);
    }
    std::vector<Reached> found;
    for (const RayTile& tile : tiles) {
      if (!tile.box().intersects(swept)) continue;
      Reached one{&tile, kInfinity, {}};
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        one.start_m[k] =
            rays.active[k] != 0 ? entry_m(tile.box(), origin_of(rays, k), way_of(rays, k), rays.far_m[k]) : kInfinity;
        one.soonest_m = std::min(one.soonest_m, one.start_m[k]);
      }
      if (one.soonest_m < kInfinity) found.push_back(one);
    }
    std::ranges::stable_sort(found, {}, &Reached::soonest_m);
    return found;
  }

  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
    if (const RayTile* tile = only_tile(rays)) return tile->cast(rays, hits);
    for (std::size_t k = 0; k < rays.size(); ++k) cast_through_tiles(rays[k], hits[k]);
  }

  void cast_through_tiles(const ExactRays& rays, ExactHits& hits) const {
    hits.distance_m.fill(kInfinity);
    hits.normal_x.fill(0);
    hits.normal_y.fill(0);
    hits.normal_z.fill(0);
    hits.label.fill(kNothing);
    ExactRays left = rays;
    for (Reached& next : reached(rays)) {
      for (std::size_t k = 0; k < kPacketRays; ++k) left.active[k] = next.start_m[k] < hits.distance_m[k] ? -1 : 0;
      for (std::size_t k = 0; k < kPacketRays; ++k) next.start_m[k] = left.active[k] != 0 ? next.start_m[k] : 0;
      ExactHits part;
      next.tile->cast(left, next.start_m.data(), part);
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        if (part.distance_m[k] < hits.distance_m[k]) copy_lane(part, hits, k);
      }
    }
  }

  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits, RayOrder order) const {
    if (const RayTile* tile = only_tile(anchor_world_m)) return tile->cast(anchor_world_m, rays, nullptr, hits, order);
    hits = {};
    hits.distance_m.fill(std::numeric_limits<float>::infinity());
    RayPacket left = rays;
    for (Reached& next : reached(exact(anchor_world_m, rays))) {
      for (std::size_t k = 0; k < kPacketRays; ++k) left.active[k] = next.start_m[k] < hits.distance_m[k] ? -1 : 0;
      for (std::size_t k = 0; k < kPacketRays; ++k) next.start_m[k] = left.active[k] != 0 ? next.start_m[k] : 0;
      HitPacket part;
      next.tile->cast(anchor_world_m, left, next.start_m.data(), part, order);
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        if (left.active[k] != 0 && part.distance_m[k] < hits.distance_m[k]) copy_lane(part, hits, k);
      }
    }
  }

  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, Blocked& blocked, RayOrder order) const {
    if (const RayTile* tile = only_tile(anchor_world_m)) {
      return tile->occluded(anchor_world_m, rays, nullptr, blocked, order);
    }
    blocked.fill(0);
    RayPacket left = rays;
    for (Reached& next : reached(exact(anchor_world_m, rays))) {
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        left.active[k] = blocked[k] == 0 && next.start_m[k] < kInfinity ? -1 : 0;
        if (left.active[k] == 0) next.start_m[k] = 0;
      }
      Blocked part;
      next.tile->occluded(anchor_world_m, left, next.start_m.data(), part, order);
      for (std::size_t k = 0; k < kPacketRays; ++k) blocked[k] |= part[k];
    }
  }

  double distance_to(const Eigen::Vector3d& point_world_m) const {
    std::vector<std::pair<double, const RayTile*>> by_distance;
    for (const RayTile& tile : tiles) by_distance.emplace_back(tile.box().exteriorDistance(point_world_m), &tile);
    std::ranges::stable_sort(by_distance, {}, [](const auto& entry) { return entry.first; });
    double nearest_m = kInfinity;
    for (const auto& [to_box_m, tile] : by_distance) {
      if (to_box_m >= nearest_m) break;
      nearest_m = tile->distance(point_world_m, nearest_m);
    }
    return nearest_m;
  }

  void cast_range(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits) const {
    ExactRays packet;
    ExactHits met;
    for (std::size_t first = 0; first < rays.size(); first += kPacketRays) {
      const std::size_t count = std::min(kPacketRays, rays.size() - first);
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        const Ray& ray = rays[first + std::min(k, count - 1)];
        const bool sane = ray.origin_world_m.allFinite() && ray.direction_world.allFinite();
        set_ray(packet, k, ray.origin_world_m, ray.direction_world, max_range_m, k < count && sane);
      }
      cast({&packet, 1}, {&met, 1});
      for (std::size_t k = 0; k < count; ++k) {
        const Eigen::Vector3d normal(met.normal_x[k], met.normal_y[k], met.normal_z[k]);
        hits[first + k] = {met.distance_m[k], normal.cast<float>(), static_cast<Label>(met.label[k])};
      }
    }
  }
};

RayScene::RayScene(const World& world) : impl_(std::make_unique<Impl>(world)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::cast(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits, int threads) const {
  require(hits.size() == rays.size(), "hits.size", hits.size(), "must equal the number of rays");
  parallel_ranges(rays.size(), threads, [&](std::size_t first, std::size_t last) {
    impl_->cast_range(rays.subspan(first, last - first), max_range_m, hits.subspan(first, last - first));
  });
}

RayHit RayScene::cast(const Ray& ray, double max_range_m) const {
  RayHit hit;
  impl_->cast_range({&ray, 1}, max_range_m, {&hit, 1});
  return hit;
}

void RayScene::cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
  require(hits.size() == rays.size(), "hits.size", hits.size(), "must equal the number of packets");
  impl_->cast(rays, hits);
}

void RayScene::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
                    RayOrder order) const {
  impl_->cast(anchor_world_m, rays, hits, order);
}

void RayScene::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, Blocked& blocked,
                        RayOrder order) const {
  impl_->occluded(anchor_world_m, rays, blocked, order);
}

bool RayScene::under_ground(const Eigen::Vector3d& point_world_m) const {
  const auto& terrain = impl_->terrain;
  return terrain && point_world_m.z() <= terrain->height_at(point_world_m.x(), point_world_m.y());
}

void RayScene::distance(std::span<const Eigen::Vector3d> points_world_m, std::span<double> distances_m,
                        int threads) const {
  require(distances_m.size() == points_world_m.size(), "distances_m.size", distances_m.size(),
          "must equal the number of points");
  parallel_ranges(points_world_m.size(), threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) distances_m[k] = impl_->distance_to(points_world_m[k]);
  });
}

}  // namespace uwsim
