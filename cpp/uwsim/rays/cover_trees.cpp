#include "uwsim/rays/cover_trees.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/rays/cover_walk.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/tolerances.h"
#include "uwsim/rays/triangle_hit.h"

namespace uwsim {

CoverTrees::CoverTrees(RTCDeviceTy* device, const World& surfaces, std::size_t most_pieces)
    : device_(device),
      plan_(surfaces),
      reach_m_(plan_.reach_m()),
      first_label_(surfaces.first_cover()),
      lowest_m_(surfaces.terrain()->lowest_m()),
      highest_m_(surfaces.terrain()->highest_m()),
      heights_(std::size_t{plan_.columns()} * plan_.rows()),
      tiles_(heights_.size(), most_pieces) {
  for (const auto& layer : surfaces.cover()) {
    layers_.push_back(layer);
    for (const TriangleMesh& mesh : layer->meshes) shapes_.emplace_back(device, mesh, *layer);
    // A plant that leans reaches farther aside, by at most its height.
    if (layer->sways()) reach_m_ = std::numbers::sqrt2 * plan_.reach_m();
  }
  const Heightfield& terrain = *surfaces.terrain();
  // The first and last node around a tile, along one axis.
  const auto nodes = [&](std::uint32_t tile, std::size_t count) {
    const double nodes_a_tile = plan_.tile_m() / terrain.spacing_m();
    return std::pair(std::min(static_cast<std::size_t>(std::floor(tile * nodes_a_tile)), count - 1),
                     std::min(static_cast<std::size_t>(std::ceil((tile + 1.0) * nodes_a_tile)), count - 1));
  };
  for (std::uint32_t row = 0; row < plan_.rows(); ++row) {
    const auto [south, north] = nodes(row, terrain.ny());
    for (std::uint32_t column = 0; column < plan_.columns(); ++column) {
      const auto [west, east] = nodes(column, terrain.nx());
      Eigen::AlignedBox1d& heights = heights_[std::size_t{row} * plan_.columns() + column];
      for (std::size_t j = south; j <= north; ++j) {
        for (std::size_t i = west; i <= east; ++i) {
          heights.extend(Eigen::Matrix<double, 1, 1>(terrain.heights_m()[j * terrain.nx() + i]));
        }
      }
    }
  }
}

const CoverTile& CoverTrees::tile(std::uint32_t column, std::uint32_t row) const {
  return tiles_.get(std::size_t{row} * plan_.columns() + column,
                    [&] { return CoverTile(device_, shapes_, plan_.pieces(column, row)); });
}

/// The box of all that a tile may hold.
Eigen::AlignedBox3d CoverTrees::box_of(std::uint32_t column, std::uint32_t row) const {
  const double reach = reach_m_, width = plan_.tile_m();
  const Eigen::AlignedBox1d& z = heights_[std::size_t{row} * plan_.columns() + column];
  const Eigen::Vector2d low = plan_.origin_m() + width * Eigen::Vector2d(column, row);
  return {Eigen::Vector3d(low.x() - reach, low.y() - reach, z.min()(0) - reach),
          Eigen::Vector3d(low.x() + width + reach, low.y() + width + reach, z.max()(0) + reach)};
}

/// Calls visit(tile, lanes) for the tiles that rays enter before their end, the nearest first.
template <typename Visit>
void CoverTrees::for_each_tile(Walk& walk, const std::shared_ptr<const Sway>& sway, const Visit& visit) const {
  const double reach = reach_m_, width = plan_.tile_m();
  // The part of the grid that the rays may enter: for each lane, the ends of its way through the whole grid.
  Eigen::AlignedBox3d whole(box_of(0, 0)), way;
  whole.extend(box_of(plan_.columns() - 1, plan_.rows() - 1));
  whole.min().z() = lowest_m_ - reach, whole.max().z() = highest_m_ + reach;
  Walk::Lanes first_m, last_m, lane_m;
  if (walk.enter(whole, first_m) == kInfinity) return;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double start = first_m[k];
    if (start == kInfinity) {
      walk.active[k] = 0;
      continue;
    }
    last_m[k] = walk.exit(k, whole);
    for (const double t : {start, last_m[k]}) {
      way.extend(Eigen::Vector3d(walk.origin[0][k] + t * walk.direction[0][k],
                                 walk.origin[1][k] + t * walk.direction[1][k], 0));
    }
  }
  if (way.isEmpty()) return;
  const Walk::Bounds all = walk.bounds();
  const auto number = [&](double at, int axis, double beyond, std::uint32_t count) {
    const double n = std::floor((at + beyond - plan_.origin_m()(axis)) / width);
    return static_cast<std::uint32_t>(std::clamp(n, 0.0, count - 1.0));
  };
  const std::uint32_t low = number(way.min().y(), 1, -reach, plan_.rows()),
                      high = number(way.max().y(), 1, reach, plan_.rows());
  // The southern and northern limits of what a row's tiles hold.
  const auto row_of = [&](std::uint32_t row) {
    const double south = plan_.origin_m().y() + row * width - reach;
    return std::pair(south, south + width + 2 * reach);
  };
  struct Entered {
    double first_m = 0;
    const Eigen::AlignedBox3d* box = nullptr;
    const CoverTile* tile = nullptr;
    const CoverTile::Target* target = nullptr;  // null: the plants'
    std::shared_ptr<const CoverTile::Plants> plants = nullptr;
  };
  thread_local std::vector<Entered> entered;
  entered.clear();
  // Rays that stay near cross few tiles: testing them all costs less than following each ray from row to row.
  constexpr double kFewTiles = 12;
  const bool few = (high - low + 1) * ((way.sizes().x() + 2 * reach) / width + 2) <= kFewTiles;
  for (std::uint32_t row = low; row <= high; ++row) {
    const auto [west, east] = few ? std::pair(way.min().x(), way.max().x()) : walk.across(row_of(row), first_m, last_m);
    if (west > east) continue;
    const std::uint32_t left = number(west, 0, -reach, plan_.columns()),
                        right = number(east, 0, reach, plan_.columns());
    for (std::uint32_t column = left; column <= right; ++column) {
      // A tile in memory has the smaller box.
      if (!tiles_.is_made(std::size_t{row} * plan_.columns() + column)) {
        const Eigen::AlignedBox3d box = box_of(column, row);
        if (all.enter(box) == kInfinity || walk.enter(box, lane_m) == kInfinity) continue;
      }
      const CoverTile& next = tile(column, row);
      if (all.enter(next.box()) == kInfinity) continue;
      const auto consider = [&](const Eigen::AlignedBox3d& box, Entered as) {
        as.first_m = box.isEmpty() ? kInfinity : all.enter(box);
        if (as.first_m == kInfinity) return;
        as.box = &box;
        entered.insert(std::ranges::upper_bound(entered, as.first_m, {}, &Entered::first_m), std::move(as));
      };
      const bool sways = sway != nullptr && next.sways();
      const CoverTile::Target& target = sways ? next.stiff() : next.still();
      consider(target.box, {.tile = &next, .target = &target});
      if (!sways) continue;
      std::shared_ptr<const CoverTile::Plants> plants = next.plants(sway);
      consider(plants->box(), {.tile = &next, .plants = plants});
    }
  }
  for (const Entered& next : entered) {
    alignas(64) std::array<std::int32_t, kPacketRays> lanes;  // as Embree requires
    if (walk.enter(*next.box, lane_m) == kInfinity) continue;
    for (std::size_t k = 0; k < kPacketRays; ++k) lanes[k] = lane_m[k] < kInfinity ? -1 : 0;
    const CoverTile::Target& target = next.plants ? next.plants->target() : *next.target;
    visit(CoverTarget{*next.tile, target.tree.get(), next.plants ? next.plants->leans() : std::span<const Lean>()},
          lanes);
  }
  entered.clear();
}

void CoverTrees::cast(std::span<const ExactRays> rays, const std::shared_ptr<const Sway>& sway,
                      std::span<ExactHits> hits) const {
  const InUse in_use(tiles_);
  for (std::size_t p = 0; p < rays.size(); ++p) {
    Walk walk(Eigen::Vector3d::Zero(), rays[p], hits[p].distance_m);
    for_each_tile(walk, sway, [&](const CoverTarget& target, const std::array<std::int32_t, kPacketRays>& lanes) {
      const RTCRayHit16 packet = met(target, walk, lanes);
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        if (lanes[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        const CoverPiece& piece = target.tile.pieces()[packet.hit.instID[0][k]];
        const PieceHit hit = solve(target.tile.corners(piece, packet.hit.primID[k], target.leans),
                                   origin_of(rays[p], k), direction_of(rays[p], k), double{packet.ray.tfar[k]});
        if (!(hit.distance_m < walk.far_m[k])) continue;
        walk.far_m[k] = hit.distance_m;
        set_hit(hits[p], k, hit.distance_m, hit.normal, static_cast<Label>(first_label_ + piece.layer));
      }
    });
  }
}

void CoverTrees::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder,
                      const std::shared_ptr<const Sway>& sway, HitPacket& hits) const {
  const InUse in_use(tiles_);
  Walk walk(anchor_world_m, rays, hits.distance_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) walk.near_m[k] = rays.near_m[k];
  for_each_tile(walk, sway, [&](const CoverTarget& target, const std::array<std::int32_t, kPacketRays>& lanes) {
    const RTCRayHit16 packet = met(target, walk, lanes);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (lanes[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      const CoverPiece& piece = target.tile.pieces()[packet.hit.instID[0][k]];
      const Eigen::Vector3d origin = anchor_world_m + origin_of(rays, k), direction = direction_of(rays, k);
      const PieceHit hit = solve(target.tile.corners(piece, packet.hit.primID[k], target.leans), origin, direction,
                                 double{packet.ray.tfar[k]});
      if (!(hit.distance_m < walk.far_m[k])) continue;
      walk.far_m[k] = hit.distance_m;
      hits.distance_m[k] = static_cast<float>(hit.distance_m);
      hits.u[k] = static_cast<float>(hit.u), hits.v[k] = static_cast<float>(hit.v);
      const Eigen::Vector3f normal = hit.normal.cast<float>();
      hits.normal_x[k] = normal.x(), hits.normal_y[k] = normal.y(), hits.normal_z[k] = normal.z();
      hits.label[k] = first_label_ + piece.layer;
      hits.primitive[k] = packet.hit.primID[k];
      hits.piece[k] = piece.number;
      hits.settled[k] = -1;
      const SmoothPlace smooth = target.tile.smooth(piece, packet.hit.primID[k], hits.u[k], hits.v[k], target.leans);
      hits.smooth_x[k] = smooth.normal.x(), hits.smooth_y[k] = smooth.normal.y(), hits.smooth_z[k] = smooth.normal.z();
      hits.rise_m[k] = smooth.rise_m;
    }
  });
}

void CoverTrees::occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder,
                         const std::shared_ptr<const Sway>& sway, Blocked& blocked) const {
  const InUse in_use(tiles_);
  Walk walk(anchor_world_m, rays, rays.far_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    walk.near_m[k] = rays.near_m[k];
    if (blocked[k] != 0) walk.active[k] = 0;
  }
  for_each_tile(walk, sway, [&](const CoverTarget& target, const std::array<std::int32_t, kPacketRays>& lanes) {
    RTCRay16 packet;
    fill(walk, target.tile.middle_m(), lanes, packet);
    occluded(target.tree, {}, RayOrder::kIncoherent, lanes.data(), packet);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (lanes[k] == 0 || packet.tfar[k] != -std::numeric_limits<float>::infinity()) continue;
      blocked[k] = -1;
      walk.active[k] = 0;
    }
  });
}

Eigen::Matrix3f CoverTrees::turn_of(std::uint32_t piece) const {
  const InUse in_use(tiles_);
  const auto [column, row] = plan_.tile_of(piece);
  if (row >= plan_.rows()) return Eigen::Matrix3f::Identity();
  const std::vector<CoverPiece>& pieces = tile(column, row).pieces();
  const auto found = std::ranges::find(pieces, piece, &CoverPiece::number);
  return found == pieces.end() ? Eigen::Matrix3f::Identity() : found->turn;
}

double CoverTrees::distance(const Eigen::Vector3d& point_world_m, const std::shared_ptr<const Sway>& sway,
                            double nearest_m) const {
  if (!point_world_m.allFinite()) return nearest_m;
  const InUse in_use(tiles_);
  const double reach = reach_m_, width = plan_.tile_m();
  const auto numbers = [&](int axis, std::uint32_t count) {
    const double at = point_world_m(axis) - plan_.origin_m()(axis), far = std::min(nearest_m, 1e7) + reach;
    return std::pair(static_cast<std::int64_t>(std::clamp(std::floor((at - far) / width), 0.0, 1.0 * count)),
                     static_cast<std::int64_t>(std::clamp(std::floor((at + far) / width), -1.0, count - 1.0)));
  };
  const auto [left, right] = numbers(0, plan_.columns());
  const auto [low, high] = numbers(1, plan_.rows());
  for (std::int64_t row = low; row <= high; ++row) {
    for (std::int64_t column = left; column <= right; ++column) {
      const auto i = static_cast<std::uint32_t>(column), j = static_cast<std::uint32_t>(row);
      if (box_of(i, j).exteriorDistance(point_world_m) >= nearest_m) continue;
      const CoverTile& near = tile(i, j);
      if (near.pieces().empty()) continue;
      if (sway == nullptr || !near.sways()) {
        if (near.still().box.exteriorDistance(point_world_m) >= nearest_m) continue;
        nearest_m = near.distance(point_world_m, nearest_m, {});
      } else {
        nearest_m = near.distance(point_world_m, nearest_m, near.plants(sway)->leans());
      }
    }
  }
  return nearest_m;
}

}  // namespace uwsim
