#include "uwsim/rays/ray_scene.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "uwsim/core/built_when_used.h"
#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/core/parallel.h"
#include "uwsim/core/recently_made.h"
#include "uwsim/rays/cover_trees.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/ray_tile.h"
#include "uwsim/rays/reached_tiles.h"
#include "uwsim/rays/tiling.h"
#include "uwsim/world/same_surfaces.h"

namespace uwsim {
namespace {

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

ExactRays to_double(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays) {
  ExactRays out;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    set_ray(out, k, anchor_world_m + origin_of(rays, k), direction_of(rays, k), rays.far_m[k], rays.active[k] != 0);
  }
  return out;
}

/// Deactivates the rays that do not enter the tile before their nearest hit so far.
template <typename Packet>
void keep_rays_that_may_hit_sooner(ReachedTile& next, const auto& distance_m, Packet& left) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    left.active[k] = next.start_m[k] < distance_m[k] ? -1 : 0;
    if (left.active[k] == 0) next.start_m[k] = 0;
  }
}

}  // namespace

/// The fixed surfaces. Building their trees takes most of the time for creating a simulator, so the first ray does it.
struct RayScene::Fixed {
  World surfaces;  // without water

  explicit Fixed(const World& world) : surfaces(world) { surfaces.water = {}; }

  const std::vector<RayTile>& tiles() const {
    return trees_.get([this] { return Trees(surfaces); }).tiles;
  }

  /// The cover; null if there is none.
  const CoverTrees* cover() const {
    return surfaces.cover().empty() ? nullptr : trees_.get([this] { return Trees(surfaces); }).cover.get();
  }

  /// The usual case: a single tile, and rays that need no shift to its box.
  const RayTile* only_tile(std::span<const ExactRays> rays) const {
    const std::vector<RayTile>& tiles = this->tiles();
    return tiles.size() == 1 && tiles.front().is_near(rays) ? &tiles.front() : nullptr;
  }

  const RayTile* only_tile(const Eigen::Vector3d& anchor_world_m) const {
    const std::vector<RayTile>& tiles = this->tiles();
    return tiles.size() == 1 && tiles.front().is_near(anchor_world_m) ? &tiles.front() : nullptr;
  }

  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
    if (const RayTile* tile = only_tile(rays)) return tile->cast(rays, hits);
    for (std::size_t k = 0; k < rays.size(); ++k) cast_through_tiles(rays[k], hits[k]);
  }

  void cast_through_tiles(const ExactRays& rays, ExactHits& hits) const {
    set_all_missed(hits);
    ExactRays left = rays;
    for (ReachedTile& next : reached_tiles(tiles(), rays)) {
      keep_rays_that_may_hit_sooner(next, hits.distance_m, left);
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
    for (ReachedTile& next : reached_tiles(tiles(), to_double(anchor_world_m, rays))) {
      keep_rays_that_may_hit_sooner(next, hits.distance_m, left);
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
    for (ReachedTile& next : reached_tiles(tiles(), to_double(anchor_world_m, rays))) {
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        left.active[k] = blocked[k] == 0 && next.start_m[k] < kInfinity ? -1 : 0;
        if (left.active[k] == 0) next.start_m[k] = 0;
      }
      Blocked part;
      next.tile->occluded(anchor_world_m, left, next.start_m.data(), part, order);
      for (std::size_t k = 0; k < kPacketRays; ++k) blocked[k] |= part[k];
    }
  }

  /// The smaller of `nearest_m` and the distance to the nearest surface.
  double distance_to(const Eigen::Vector3d& point_world_m, double nearest_m) const {
    const std::vector<RayTile>& tiles = this->tiles();
    if (tiles.size() == 1) return tiles.front().distance(point_world_m, nearest_m);
    std::vector<std::pair<double, const RayTile*>> by_distance;
    for (const RayTile& tile : tiles) by_distance.emplace_back(tile.box().exteriorDistance(point_world_m), &tile);
    std::ranges::stable_sort(by_distance, {}, [](const auto& entry) { return entry.first; });
    for (const auto& [to_box_m, tile] : by_distance) {
      if (to_box_m >= nearest_m) break;
      nearest_m = tile->distance(point_world_m, nearest_m);
    }
    return nearest_m;
  }

 private:
  struct Trees {
    RayDevice device = make_ray_device();
    std::vector<RayTile> tiles;
    std::unique_ptr<const CoverTrees> cover;

    explicit Trees(const World& surfaces) {
      for (TileContents& contents : cut_into_tiles(surfaces)) {
        tiles.emplace_back(device.get(), surfaces, std::move(contents));
      }
      if (!surfaces.cover().empty()) cover = std::make_unique<const CoverTrees>(device.get(), surfaces);
    }
  };

  BuiltWhenUsed<Trees> trees_;
};

/// Scenes of worlds with the same surfaces share them, and thereby their trees.
RayScene::RayScene(const World& world) {
  // Never destroyed, because Embree's static objects may be destroyed before ours.
  static auto& made = *new RecentlyMade<Fixed>;
  const bool has_terrain = world.terrain() != nullptr;  // worlds without terrain are bodies, which are quick to build
  fixed_ = made.find_or_make(
      has_terrain, [&](const Fixed& known) { return have_same_surfaces(known.surfaces, world); },
      [&] { return std::make_shared<const Fixed>(world); });
}

void RayScene::prepare() const { fixed_->tiles(); }

RayScene RayScene::with(std::shared_ptr<const MovingBodies> bodies, std::size_t hidden) const {
  RayScene scene = *this;
  scene.bodies_ = std::move(bodies);
  scene.hidden_ = hidden;
  return scene;
}

RayScene RayScene::with_plants(std::shared_ptr<const Sway> sway) const {
  RayScene scene = *this;
  scene.sway_ = std::move(sway);
  return scene;
}

bool RayScene::bodies_in(const RayCone& cone) const { return bodies_ && bodies_->may_be_in(cone, hidden_); }

void RayScene::cast_packets(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
  fixed_->cast(rays, hits);
  if (const CoverTrees* cover = fixed_->cover()) cover->cast(rays, sway_, hits);
  if (bodies_) bodies_->cast(rays, hidden_, hits);
}

void RayScene::cast_range(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits) const {
  ExactRays packet;
  ExactHits met;
  for (std::size_t first = 0; first < rays.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, rays.size() - first);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const Ray& ray = rays[first + std::min(k, count - 1)];
      const bool finite = ray.origin_world_m.allFinite() && ray.direction_world.allFinite();
      set_ray(packet, k, ray.origin_world_m, ray.direction_world, max_range_m, k < count && finite);
    }
    cast_packets({&packet, 1}, {&met, 1});
    for (std::size_t k = 0; k < count; ++k) {
      hits[first + k] = {met.distance_m[k], normal_of(met, k).cast<float>(), static_cast<Label>(met.label[k])};
    }
  }
}

void RayScene::cast(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits, int threads) const {
  require(hits.size() == rays.size(), "hits.size", hits.size(), "must equal the number of rays");
  parallel_ranges(rays.size(), threads, [&](std::size_t first, std::size_t last) {
    cast_range(rays.subspan(first, last - first), max_range_m, hits.subspan(first, last - first));
  });
}

RayHit RayScene::cast(const Ray& ray, double max_range_m) const {
  RayHit hit;
  cast_range({&ray, 1}, max_range_m, {&hit, 1});
  return hit;
}

void RayScene::cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
  require(hits.size() == rays.size(), "hits.size", hits.size(), "must equal the number of packets");
  cast_packets(rays, hits);
}

void RayScene::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
                    RayOrder order) const {
  fixed_->cast(anchor_world_m, rays, hits, order);
  hits.piece.fill(0), hits.smooth_x.fill(0), hits.smooth_y.fill(0), hits.smooth_z.fill(0);
  if (const CoverTrees* cover = fixed_->cover()) cover->cast(anchor_world_m, rays, order, sway_, hits);
  if (bodies_) bodies_->cast(anchor_world_m, rays, order, hidden_, hits);
}

void RayScene::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, Blocked& blocked,
                        RayOrder order) const {
  fixed_->occluded(anchor_world_m, rays, blocked, order);
  if (const CoverTrees* cover = fixed_->cover()) cover->occlude(anchor_world_m, rays, order, sway_, blocked);
  if (bodies_) bodies_->occlude(anchor_world_m, rays, order, hidden_, blocked);
}

Eigen::Matrix3f RayScene::mesh_turn(Label label, std::uint32_t piece) const {
  if (label < fixed_->surfaces.first_cover()) return Eigen::Matrix3f::Identity();
  if (label < fixed_->surfaces.labels_end()) return fixed_->cover()->turn_of(piece);
  return bodies_ ? bodies_->turn_of(label) : Eigen::Matrix3f::Identity();
}

Eigen::Vector3d RayScene::on_mesh(Label label, const Eigen::Vector3d& point_world_m) const {
  const bool is_fixed = label < fixed_->surfaces.labels_end() || !bodies_;
  return is_fixed ? point_world_m : bodies_->on_body(label, point_world_m);
}

const Heightfield* RayScene::terrain() const { return fixed_->surfaces.terrain().get(); }

bool RayScene::under_ground(const Eigen::Vector3d& point_world_m) const {
  return terrain() && point_world_m.z() <= terrain()->height_at(point_world_m.x(), point_world_m.y());
}

std::vector<PlacedPiece> RayScene::cover_in(const Eigen::AlignedBox2d& area_world_m) const {
  std::vector<PlacedPiece> found;
  const CoverTrees* cover = fixed_->cover();
  if (cover == nullptr) return found;
  const CoverPlan& plan = cover->plan();
  for (std::uint32_t row = 0; row < plan.rows(); ++row) {
    for (std::uint32_t column = 0; column < plan.columns(); ++column) {
      const Eigen::Vector2d low = plan.origin_m() + plan.tile_m() * Eigen::Vector2d(column, row);
      if (!area_world_m.intersects({low, low + Eigen::Vector2d::Constant(plan.tile_m())})) continue;
      const CoverTilePlan tile = plan.pieces(column, row);
      for (const CoverPiece& piece : tile.pieces) {
        const Eigen::Vector3d at = tile.middle_m + piece.at_m.cast<double>();
        if (!area_world_m.contains(at.head<2>())) continue;
        found.push_back(
            {at, piece.size_m, static_cast<Label>(fixed_->surfaces.first_cover() + piece.layer), piece.number});
      }
    }
  }
  return found;
}

bool RayScene::within_round(const Eigen::Vector3d& point_world_m, double depth_m) const {
  for (const auto& solid : fixed_->surfaces.solids()) {
    if ((point_world_m.array() < solid->low_world_m.array()).any()) continue;
    if ((point_world_m.array() > solid->high_world_m.array()).any()) continue;
    for (const RoundShape& shape : solid->shapes) {
      if (depth_within(shape, point_world_m) > depth_m) return true;
    }
  }
  return false;
}

void RayScene::distance(std::span<const Eigen::Vector3d> points_world_m, std::span<double> distances_m,
                        int threads) const {
  require(distances_m.size() == points_world_m.size(), "distances_m.size", distances_m.size(),
          "must equal the number of points");
  parallel_ranges(points_world_m.size(), threads, [&](std::size_t first, std::size_t last) {
    double nearest_m = kInfinity;
    for (std::size_t k = first; k < last; ++k) {
      double fixed_m = fixed_->distance_to(points_world_m[k], nearest_m);
      if (const CoverTrees* cover = fixed_->cover()) fixed_m = cover->distance(points_world_m[k], sway_, fixed_m);
      distances_m[k] = bodies_ ? bodies_->distance(points_world_m[k], fixed_m, hidden_) : fixed_m;
      // Neighbours in the list are usually neighbours in space. The next point's distance to the nearest surface
      // exceeds this one's by at most the distance between the two points.
      const double apart_m = k + 1 < last ? (points_world_m[k + 1] - points_world_m[k]).norm() : 0;
      nearest_m = (fixed_m + apart_m) * (1 + kFartherSearch) + kFartherSearch;
    }
  });
}

}  // namespace uwsim
