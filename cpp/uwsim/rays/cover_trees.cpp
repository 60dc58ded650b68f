#include "uwsim/rays/cover_trees.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/rays/cover_walk.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/tolerances.h"
#include "uwsim/rays/triangle_hit.h"

namespace uwsim {
namespace {

/// A mesh in an Embree tree of its own.
RayTree mesh_tree(RTCDeviceTy* device, const std::vector<Eigen::Vector3f>& vertices,
                  const std::vector<Triangle>& triangles) {
  GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  void* vertex = rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                         sizeof(Eigen::Vector3f), vertices.size());
  void* index = rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle),
                                        triangles.size());
  require(vertex != nullptr && index != nullptr, "cover.triangles", triangles.size(), "not enough memory for them");
  std::memcpy(vertex, vertices.data(), vertices.size() * sizeof(Eigen::Vector3f));
  std::memcpy(index, triangles.data(), triangles.size() * sizeof(Triangle));
  RayTree tree = make_ray_tree(device, true);
  attach(tree.get(), owner, 0);
  commit(device, tree.get(), triangles.size());
  return tree;
}

}  // namespace

CoverTrees::CoverTrees(RTCDeviceTy* device, const World& surfaces, std::size_t most_pieces)
    : device_(device),
      plan_(surfaces),
      first_label_(surfaces.first_cover()),
      lowest_m_(surfaces.terrain()->lowest_m()),
      highest_m_(surfaces.terrain()->highest_m()),
      heights_(std::size_t{plan_.columns()} * plan_.rows()),
      tiles_(heights_.size(), most_pieces) {
  for (const auto& layer : surfaces.cover()) {
    for (const TriangleMesh& mesh : layer->meshes) {
      Mesh made;
      for (const Eigen::Vector3d& v : mesh.vertices_m) made.vertices.push_back(v.cast<float>());
      made.triangles = mesh.triangles;
      made.tree = mesh_tree(device, made.vertices, made.triangles);
      meshes_.push_back(std::move(made));
    }
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

const CoverTrees::Tile& CoverTrees::tile(std::uint32_t column, std::uint32_t row) const {
  return tiles_.get(std::size_t{row} * plan_.columns() + column, [&] { return make_tile(column, row); });
}

CoverTrees::Tile CoverTrees::make_tile(std::uint32_t column, std::uint32_t row) const {
  CoverTilePlan plan = plan_.pieces(column, row);
  Tile made{plan.middle_m, {}, std::move(plan.pieces), make_ray_tree(device_, true)};
  for (std::uint32_t k = 0; k < made.pieces.size(); ++k) {
    const CoverPiece& piece = made.pieces[k];
    GeometryOwner owner(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(owner.get(), meshes_[piece.mesh].tree.get());
    std::array<float, 12> place;  // columns of the rotation, then the translation
    std::copy_n(piece.turn.data(), 9, place.begin());
    std::copy_n(piece.at_m.data(), 3, place.begin() + 9);
    rtcSetGeometryTransform(owner.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, place.data());
    attach(made.tree.get(), owner, k);
  }
  commit(device_, made.tree.get(), made.pieces.size());
  if (made.pieces.empty()) return made;  // its box is empty, so that no ray enters it
  RTCBounds bounds;
  rtcGetSceneBounds(made.tree.get(), &bounds);
  constexpr double kMargin_m = 1e-3;
  made.box = {made.middle_m + Eigen::Vector3d(bounds.lower_x, bounds.lower_y, bounds.lower_z) -
                  Eigen::Vector3d::Constant(kMargin_m),
              made.middle_m + Eigen::Vector3d(bounds.upper_x, bounds.upper_y, bounds.upper_z) +
                  Eigen::Vector3d::Constant(kMargin_m)};
  return made;
}

Corners CoverTrees::corners(const Tile& tile, const CoverPiece& piece, std::uint32_t triangle) const {
  const Mesh& mesh = meshes_[piece.mesh];
  const Eigen::Matrix3d turn = piece.turn.cast<double>();
  const Eigen::Vector3d at = tile.middle_m + piece.at_m.cast<double>();
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = at + turn * mesh.vertices[mesh.triangles[triangle][k]].cast<double>();
  return corners;
}

/// The box of all that a tile may hold.
Eigen::AlignedBox3d CoverTrees::box_of(std::uint32_t column, std::uint32_t row) const {
  const double reach = plan_.reach_m(), width = plan_.tile_m();
  const Eigen::AlignedBox1d& z = heights_[std::size_t{row} * plan_.columns() + column];
  const Eigen::Vector2d low = plan_.origin_m() + width * Eigen::Vector2d(column, row);
  return {Eigen::Vector3d(low.x() - reach, low.y() - reach, z.min()(0) - reach),
          Eigen::Vector3d(low.x() + width + reach, low.y() + width + reach, z.max()(0) + reach)};
}

/// Calls visit(tile, lanes) for the tiles that rays enter before their end, the nearest first.
template <typename Visit>
void CoverTrees::for_each_tile(Walk& walk, const Visit& visit) const {
  const double reach = plan_.reach_m(), width = plan_.tile_m();
  // The part of the grid that the rays may enter: for each lane, the ends of its way through the whole grid.
  Eigen::AlignedBox3d whole(box_of(0, 0)), way;
  whole.extend(box_of(plan_.columns() - 1, plan_.rows() - 1));
  whole.min().z() = lowest_m_ - reach, whole.max().z() = highest_m_ + reach;
  Walk::Lanes first_m, last_m;
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
    const Tile* tile = nullptr;
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
      const bool is_made = tiles_.is_made(std::size_t{row} * plan_.columns() + column);
      if (!is_made && walk.enter(box_of(column, row)) == kInfinity) continue;
      const Tile& next = tile(column, row);
      const double first = next.pieces.empty() ? kInfinity : walk.enter(next.box);
      if (first == kInfinity) continue;
      entered.insert(std::ranges::upper_bound(entered, first, {}, &Entered::first_m), {first, &next});
    }
  }
  for (const Entered& next : entered) {
    alignas(64) std::array<std::int32_t, kPacketRays> lanes;  // as Embree requires
    if (walk.enter(next.tile->box, first_m) == kInfinity) continue;
    for (std::size_t k = 0; k < kPacketRays; ++k) lanes[k] = first_m[k] < kInfinity ? -1 : 0;
    visit(*next.tile, lanes);
  }
}

void CoverTrees::cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
  const InUse in_use(tiles_);
  for (std::size_t p = 0; p < rays.size(); ++p) {
    Walk walk(Eigen::Vector3d::Zero(), rays[p], hits[p].distance_m);
    for_each_tile(walk, [&](const Tile& tile, const std::array<std::int32_t, kPacketRays>& lanes) {
      const RTCRayHit16 packet = met(tile.tree.get(), walk, tile.middle_m, lanes);
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        if (lanes[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        const CoverPiece& piece = tile.pieces[packet.hit.instID[0][k]];
        const PieceHit hit = solve(corners(tile, piece, packet.hit.primID[k]), origin_of(rays[p], k),
                                   direction_of(rays[p], k), double{packet.ray.tfar[k]});
        if (!(hit.distance_m < walk.far_m[k])) continue;
        walk.far_m[k] = hit.distance_m;
        set_hit(hits[p], k, hit.distance_m, hit.normal, static_cast<Label>(first_label_ + piece.layer));
      }
    });
  }
}

void CoverTrees::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder, HitPacket& hits) const {
  const InUse in_use(tiles_);
  hits.piece.fill(0);
  Walk walk(anchor_world_m, rays, hits.distance_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) walk.near_m[k] = rays.near_m[k];
  for_each_tile(walk, [&](const Tile& tile, const std::array<std::int32_t, kPacketRays>& lanes) {
    const RTCRayHit16 packet = met(tile.tree.get(), walk, tile.middle_m, lanes);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (lanes[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      const CoverPiece& piece = tile.pieces[packet.hit.instID[0][k]];
      const Eigen::Vector3d origin = anchor_world_m + origin_of(rays, k), direction = direction_of(rays, k);
      const PieceHit hit =
          solve(corners(tile, piece, packet.hit.primID[k]), origin, direction, double{packet.ray.tfar[k]});
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
    }
  });
}

void CoverTrees::occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder,
                         Blocked& blocked) const {
  const InUse in_use(tiles_);
  Walk walk(anchor_world_m, rays, rays.far_m);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    walk.near_m[k] = rays.near_m[k];
    if (blocked[k] != 0) walk.active[k] = 0;
  }
  for_each_tile(walk, [&](const Tile& tile, const std::array<std::int32_t, kPacketRays>& lanes) {
    RTCRay16 packet;
    fill(walk, tile.middle_m, lanes, packet);
    occluded(tile.tree.get(), {}, RayOrder::kIncoherent, lanes.data(), packet);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (lanes[k] == 0 || packet.tfar[k] != -std::numeric_limits<float>::infinity()) continue;
      blocked[k] = -1;
      walk.active[k] = 0;
    }
  });
}

namespace {

struct NearestOnMesh {
  Eigen::Vector3d point;
  double distance;
  const std::vector<Eigen::Vector3f>* vertices;
  const std::vector<Triangle>* triangles;
};

bool visit_mesh_triangle(RTCPointQueryFunctionArguments* args) {
  auto* nearest = static_cast<NearestOnMesh*>(args->userPtr);
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = (*nearest->vertices)[(*nearest->triangles)[args->primID][k]].cast<double>();
  const double own = (closest_on_triangle(nearest->point, corners) - nearest->point).norm();
  if (!(own < nearest->distance)) return false;
  nearest->distance = own;
  args->query->radius = static_cast<float>(own * (1 + kFartherSearch));
  return true;
}

}  // namespace

double CoverTrees::distance(const Eigen::Vector3d& point_world_m, double nearest_m) const {
  if (!point_world_m.allFinite()) return nearest_m;
  const InUse in_use(tiles_);
  const Eigen::Vector2d at = point_world_m.head<2>();
  const auto [left, right, low, high] = plan_.tiles_near(at, at, std::min(nearest_m, 1e7) + plan_.reach_m());
  for (std::int64_t row = low; row <= high; ++row) {
    for (std::int64_t column = left; column <= right; ++column) {
      const auto i = static_cast<std::uint32_t>(column), j = static_cast<std::uint32_t>(row);
      if (box_of(i, j).exteriorDistance(point_world_m) >= nearest_m) continue;
      const Tile& near = tile(i, j);
      if (near.pieces.empty() || near.box.exteriorDistance(point_world_m) >= nearest_m) continue;
      for (const CoverPiece& piece : near.pieces) {
        const Eigen::Vector3d from = point_world_m - near.middle_m - piece.at_m.cast<double>();
        const double size = piece.size_m;
        if (from.norm() - plan_.reach_m() >= nearest_m) continue;
        const Mesh& mesh = meshes_[piece.mesh];
        NearestOnMesh nearest{piece.turn.cast<double>().inverse() * from, nearest_m / size, &mesh.vertices,
                              &mesh.triangles};
        const Eigen::Vector3f at = nearest.point.cast<float>();
        RTCPointQuery query{at.x(), at.y(), at.z(), 0,
                            static_cast<float>(std::min(nearest.distance * (1 + kFartherSearch), 1e30))};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(mesh.tree.get(), &query, &context, &visit_mesh_triangle, &nearest);
        nearest_m = std::min(nearest_m, nearest.distance * size);
      }
    }
  }
  return nearest_m;
}

}  // namespace uwsim
