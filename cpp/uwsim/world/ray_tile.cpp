#include "uwsim/world/ray_tile.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "uwsim/world/ray_geometry.h"

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastSine = 1.7e-3;  // within 0.1 degree of tangency no one asks for more
constexpr int kTurns = 64;             // rims a ray may brush past before it is given up to float
constexpr float kFarthest = std::numeric_limits<float>::max();

/// What Embree names.
struct Named {
  std::uint32_t geometry, primitive;
  double distance_m;
};

/// What Embree passes to the callbacks of round geometries.
struct CastContext {
  RTCIntersectContext embree;
  RayDetail detail;

  CastContext(const TileSurfaces& surfaces, const ExactRays* exact, const double* starts_m, RayOrder order)
      : detail{&surfaces, exact, starts_m} {
    static_assert(offsetof(CastContext, detail) == sizeof(RTCIntersectContext));
    rtcInitIntersectContext(&embree);
    if (order == RayOrder::kCoherent) embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
};

float at_most_float(double value) { return value < kFarthest ? static_cast<float>(value) : kFarthest; }

void set_hit(ExactHits& hits, std::size_t lane, const TileHit& hit, Label label) {
  hits.distance_m[lane] = std::max(0.0, hit.distance_m);
  hits.normal_x[lane] = hit.normal_world.x();
  hits.normal_y[lane] = hit.normal_world.y();
  hits.normal_z[lane] = hit.normal_world.z();
  hits.label[lane] = label;
}

void set_miss(ExactHits& hits, std::size_t lane) {
  hits.distance_m[lane] = kInfinity;
  hits.normal_x[lane] = hits.normal_y[lane] = hits.normal_z[lane] = 0;
  hits.label[lane] = kNothing;
}

}  // namespace

struct RayTile::Impl {
  TileSurfaces surfaces;
  RTCDevice device;
  RayTree tree, mesh_tree;  // what rays meet; the meshes of what rays meet as shapes
  RTCScene scene;
  std::vector<RoundGeometry> round;
  std::vector<std::vector<std::uint8_t>> crowded;  // by geometry and primitive: another surface comes near
  TerrainBlock block{};
  TerrainSolve solve_terrain = best_terrain_solve();

  Impl(RTCDevice shared_device, const World& world, TileContents contents)
      : surfaces(world, std::move(contents)),
        device(shared_device),
        tree(make_ray_tree(device, true)),
        mesh_tree(make_ray_tree(device, false)),
        scene(tree.get()) {
    const auto geometries = static_cast<std::uint32_t>(world.solids().size() + kTerrain + 1);
    round.reserve(geometries);
    std::size_t triangles = 0;
    for (std::uint32_t geometry = 0; geometry < geometries; ++geometry) {
      if (surfaces.count(geometry) == 0) continue;
      triangles += surfaces.count(geometry);
      if (surfaces.is_round(geometry)) {
        round.push_back({&surfaces, geometry});
        attach_round(device, scene, round.back());
      } else {
        attach_triangles(device, scene, surfaces, geometry);
      }
    }
    const auto& meshes = surfaces.contents().meshes;
    for (std::size_t k = 0; k < meshes.size(); ++k) attach_mesh(device, mesh_tree.get(), surfaces, k);
    commit(device, scene, triangles);
    commit(device, mesh_tree.get(), triangles);
    if (surfaces.count(TileSurfaces::kPlainTerrain) > 0) block = surfaces.terrain_block();
    crowded.resize(geometries);
    for (const TileContents::Share& share : surfaces.contents().solids) find_crowded(share.label);
  }

  // ---- what is near ----

  struct Search {
    const Impl* tile;
    const TileRay* ray;
    double from_m, to_m;
    std::optional<TileHit> best;
    Label label = kNothing;
  };

  static bool try_primitive(RTCPointQueryFunctionArguments* args) {
    auto* search = static_cast<Search*>(args->userPtr);
    const auto hit = search->tile->surfaces.meet(args->geomID, args->primID, *search->ray);
    if (!hit || hit->distance_m < search->from_m || hit->distance_m > search->to_m) return false;
    if (search->best && search->best->distance_m <= hit->distance_m) return false;
    search->best = hit;
    search->label = TileSurfaces::label(args->geomID);
    return false;
  }

  void query(const Eigen::Vector3d& point_world_m, double radius_m, RTCPointQueryFunction visit, void* user) const {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
    RTCPointQuery sphere{p.x(), p.y(), p.z(), 0, static_cast<float>(radius_m + 4 * surfaces.reach_m())};
    rtcPointQuery(scene, &sphere, &context, visit, user);
  }

  struct Company {
    const Impl* tile;
    std::uint32_t geometry;
    Corners corners;
    Eigen::AlignedBox3d box;
    bool found;
  };

  static bool find_company(RTCPointQueryFunctionArguments* args) {
    auto* me = static_cast<Company*>(args->userPtr);
    const TileSurfaces& surfaces = me->tile->surfaces;
    Eigen::AlignedBox3d other;
    if (surfaces.is_round(args->geomID)) {
      const ShapeBounds limits = bounds(surfaces.shape(args->geomID, args->primID));
      other = {limits.low_m, limits.high_m};
    } else {
      const Corners corners = surfaces.corners(args->geomID, args->primID);
      for (const Eigen::Vector3d& corner : corners) {
        // A neighbour, or itself: the search around rims takes care of these.
        if (args->geomID == me->geometry && std::ranges::find(me->corners, corner) != me->corners.end()) return false;
        other.extend(corner);
      }
    }
    if (!me->box.intersects(other)) return false;
    me->found = true;
    args->query->radius = 0;
    return true;
  }

  void find_crowded(Label label) {
    if (surfaces.is_round(label)) return;
    crowded[label].resize(surfaces.count(label));
    for (std::uint32_t k = 0; k < crowded[label].size(); ++k) {
      Company me{this, label, surfaces.corners(label, k), {}, false};
      for (const Eigen::Vector3d& corner : me.corners) me.box.extend(corner);
      const double radius = 0.5 * me.box.diagonal().norm();
      me.box.min().array() -= 8 * surfaces.reach_m();
      me.box.max().array() += 8 * surfaces.reach_m();
      query(me.box.center(), radius, &find_company, &me);
      crowded[label][k] = me.found;
    }
  }

  // ---- exact casts ----

  double sine(const Named& named, const TileRay& ray) const {
    if (surfaces.is_round(named.geometry)) return 1;
    const Corners t = surfaces.corners(named.geometry, named.primitive);
    return std::abs((t[1] - t[0]).cross(t[2] - t[0]).stableNormalized().dot(ray.direction_world));
  }

  std::optional<Named> cast_one(const ExactRays& rays, std::size_t lane, const TileRay& ray, double start_m,
                                double from_m, const double* starts_m) const {
    CastContext context(surfaces, &rays, starts_m, RayOrder::kIncoherent);
    const Eigen::Vector3d start = ray.origin_world_m + start_m * ray.direction_world - surfaces.middle_m();
    RTCRayHit one;
    one.ray = {static_cast<float>(start.x()),
               static_cast<float>(start.y()),
               static_cast<float>(start.z()),
               static_cast<float>(from_m - start_m),
               static_cast<float>(ray.direction_world.x()),
               static_cast<float>(ray.direction_world.y()),
               static_cast<float>(ray.direction_world.z()),
               0,
               at_most_float((ray.far_m - start_m) * (1 + 1e-6) + 1e-6),
               ~0u,
               static_cast<unsigned>(lane),
               0};
    one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context.embree, &one);
    if (one.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return Named{one.hit.geomID, one.hit.primID, start_m + double{one.ray.tfar}};
  }

  /// The true first hit of a ray of which Embree says where it may be at the earliest.
  void follow(const ExactRays& rays, std::size_t lane, const double* starts_m, Named named, ExactHits& hits) const {
    const TileRay ray{{rays.origin_x[lane], rays.origin_y[lane], rays.origin_z[lane]},
                      {rays.direction_x[lane], rays.direction_y[lane], rays.direction_z[lane]},
                      rays.far_m[lane]};
    const double start_m = starts_m ? starts_m[lane] : 0;
    for (int turn = 0; turn < kTurns; ++turn) {
      const double radius = 4 * surfaces.reach_m() * (1 + 1 / std::max(kLeastSine, sine(named, ray)));
      const Eigen::Vector3d point = ray.origin_world_m + named.distance_m * ray.direction_world;
      Search search{this, &ray, std::max(0.0, named.distance_m - radius), named.distance_m + radius, {}, kTerrain};
      TileSurfaces::Around around{false, {}};
      if (named.geometry == TileSurfaces::kPlainTerrain) {
        around = surfaces.meet_terrain_around(point, radius, ray, search.from_m, search.to_m);
      }
      if (around.plain) {
        search.best = around.hit;
      } else {
        query(point, radius, &try_primitive, &search);
      }
      if (search.best) return set_hit_within(hits, lane, *search.best, search.label, ray.far_m);
      const auto next = cast_one(rays, lane, ray, start_m, named.distance_m + 0.5 * radius, starts_m);
      if (!next) return set_miss(hits, lane);
      named = *next;
    }
    const Corners t = surfaces.corners(named.geometry, named.primitive);
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized();
    set_hit_within(hits, lane, {named.distance_m, normal, false}, TileSurfaces::label(named.geometry), ray.far_m);
  }

  static void set_hit_within(ExactHits& hits, std::size_t lane, const TileHit& hit, Label label, double far_m) {
    hit.distance_m <= far_m ? set_hit(hits, lane, hit, label) : set_miss(hits, lane);
  }

  void fill(const ExactRays& rays, const double* starts_m, RTCRay16& out) const {
    const Eigen::Vector3d middle = surfaces.middle_m();
    alignas(64) std::array<double, kPacketRays> zero{};
    const double* start = starts_m ? starts_m : zero.data();
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      out.org_x[k] = static_cast<float>(rays.origin_x[k] + start[k] * rays.direction_x[k] - middle.x());
      out.org_y[k] = static_cast<float>(rays.origin_y[k] + start[k] * rays.direction_y[k] - middle.y());
      out.org_z[k] = static_cast<float>(rays.origin_z[k] + start[k] * rays.direction_z[k] - middle.z());
    }
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      out.dir_x[k] = static_cast<float>(rays.direction_x[k]);
      out.dir_y[k] = static_cast<float>(rays.direction_y[k]);
      out.dir_z[k] = static_cast<float>(rays.direction_z[k]);
      out.tnear[k] = 0;
      out.tfar[k] = at_most_float((rays.far_m[k] - start[k]) * (1 + 1e-6) + 1e-6);  // exact limits come after
      out.time[k] = 0;
      out.mask[k] = ~0u;
      out.id[k] = static_cast<unsigned>(k);
      out.flags[k] = 0;
    }
  }

  void cast(const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
    CastContext context(surfaces, &rays, starts_m, RayOrder::kCoherent);
    RTCRayHit16 packet;
    fill(rays, starts_m, packet.ray);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(rays.active.data(), scene, &context.embree, &packet);

    alignas(64) std::array<std::uint32_t, kPacketRays> triangles;
    alignas(64) std::array<std::int32_t, kPacketRays> inside;
    bool any_terrain = false;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const bool terrain = packet.hit.geomID[k] == TileSurfaces::kPlainTerrain;
      triangles[k] = terrain ? packet.hit.primID[k] : 0;
      any_terrain |= terrain;
    }
    if (any_terrain) {
      solve_terrain(
          block, triangles.data(),
          {rays.origin_x.data(), rays.origin_y.data(), rays.origin_z.data(), rays.direction_x.data(),
           rays.direction_y.data(), rays.direction_z.data()},
          {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data(), inside.data()});
    }
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::uint32_t geometry = packet.hit.geomID[k];
      if (geometry == TileSurfaces::kPlainTerrain && inside[k] && hits.distance_m[k] >= 0 &&
          hits.distance_m[k] <= rays.far_m[k]) {
        hits.label[k] = kTerrain;
      } else if (!rays.active[k] || geometry == RTC_INVALID_GEOMETRY_ID) {
        set_miss(hits, k);
      } else {
        const double start_m = starts_m ? starts_m[k] : 0;
        settle(rays, k, starts_m, {geometry, packet.hit.primID[k], start_m + double{packet.ray.tfar[k]}}, hits);
      }
    }
  }

  /// A hit on anything but the inside of a plain terrain triangle.
  void settle(const ExactRays& rays, std::size_t lane, const double* starts_m, const Named& named,
              ExactHits& hits) const {
    if (named.geometry > kTerrain) {
      const TileRay ray{{rays.origin_x[lane], rays.origin_y[lane], rays.origin_z[lane]},
                        {rays.direction_x[lane], rays.direction_y[lane], rays.direction_z[lane]},
                        rays.far_m[lane]};
      const bool alone = surfaces.is_round(named.geometry) || !crowded[named.geometry][named.primitive];
      const auto hit = surfaces.meet(named.geometry, named.primitive, ray);
      if (hit && hit->clear_of_edges && alone && hit->distance_m >= 0) {
        return set_hit_within(hits, lane, *hit, TileSurfaces::label(named.geometry), ray.far_m);
      }
    }
    follow(rays, lane, starts_m, named, hits);
  }

  // ---- casts for pictures ----

  RTCRay16 rays_of(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m) const {
    RTCRay16 out;
    const Eigen::Vector3d shift = anchor_world_m - surfaces.middle_m();
    const Eigen::Vector3f near = shift.cast<float>();
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      out.org_x[k] = near.x() + rays.origin_x[k];
      out.org_y[k] = near.y() + rays.origin_y[k];
      out.org_z[k] = near.z() + rays.origin_z[k];
      out.dir_x[k] = rays.direction_x[k];
      out.dir_y[k] = rays.direction_y[k];
      out.dir_z[k] = rays.direction_z[k];
      out.tnear[k] = rays.near_m[k];
      out.tfar[k] = rays.far_m[k];
      out.time[k] = 0;
      out.mask[k] = ~0u;
      out.id[k] = static_cast<unsigned>(k);
      out.flags[k] = 0;
    }
    for (std::size_t k = 0; starts_m != nullptr && k < kPacketRays; ++k) {
      out.org_x[k] = static_cast<float>(shift.x() + rays.origin_x[k] + starts_m[k] * rays.direction_x[k]);
      out.org_y[k] = static_cast<float>(shift.y() + rays.origin_y[k] + starts_m[k] * rays.direction_y[k]);
      out.org_z[k] = static_cast<float>(shift.z() + rays.origin_z[k] + starts_m[k] * rays.direction_z[k]);
      out.tnear[k] = std::max(0.0f, static_cast<float>(rays.near_m[k] - starts_m[k]));
      out.tfar[k] = static_cast<float>(rays.far_m[k] - starts_m[k]);
    }
    return out;
  }

  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m, HitPacket& hits,
            RayOrder order) const {
    CastContext context(surfaces, nullptr, nullptr, order);
    RTCRayHit16 packet;
    packet.ray = rays_of(anchor_world_m, rays, starts_m);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(rays.active.data(), scene, &context.embree, &packet);
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::uint32_t geometry = packet.hit.geomID[k];
      const bool met = geometry != RTC_INVALID_GEOMETRY_ID;
      const float start = starts_m != nullptr ? static_cast<float>(starts_m[k]) : 0.0f;
      hits.distance_m[k] = met ? start + packet.ray.tfar[k] : std::numeric_limits<float>::infinity();
      hits.u[k] = packet.hit.u[k];
      hits.v[k] = packet.hit.v[k];
      hits.normal_x[k] = packet.hit.Ng_x[k];
      hits.normal_y[k] = packet.hit.Ng_y[k];
      hits.normal_z[k] = packet.hit.Ng_z[k];
      hits.label[k] = met ? std::max<std::uint32_t>(geometry, kTerrain) : kNothing;
      hits.primitive[k] = met ? surfaces.world_number(geometry, packet.hit.primID[k]) : 0;
    }
  }

  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m, Blocked& blocked,
                RayOrder order) const {
    CastContext context(surfaces, nullptr, nullptr, order);
    RTCRay16 packet = rays_of(anchor_world_m, rays, starts_m);
    rtcOccluded16(rays.active.data(), scene, &context.embree, &packet);
    for (std::size_t k = 0; k < kPacketRays; ++k) {  // Embree marks what is blocked by tfar = -inf
      blocked[k] = packet.tfar[k] == -std::numeric_limits<float>::infinity() ? rays.active[k] : 0;
    }
  }
};

RayTile::RayTile(RTCDevice device, const World& world, TileContents contents)
    : impl_(std::make_unique<Impl>(device, world, std::move(contents))) {}
RayTile::~RayTile() = default;
RayTile::RayTile(RayTile&&) noexcept = default;
RayTile& RayTile::operator=(RayTile&&) noexcept = default;

const Eigen::AlignedBox3d& RayTile::box() const { return impl_->surfaces.box(); }

bool RayTile::is_near(const Eigen::Vector3d& point_world_m) const {
  return (point_world_m - impl_->surfaces.middle_m()).cwiseAbs().maxCoeff() <= impl_->surfaces.diagonal_m();
}

bool RayTile::is_near(const ExactRays& rays) const {
  const Eigen::Vector3d middle = impl_->surfaces.middle_m();
  const double reach = impl_->surfaces.diagonal_m();
  bool near = true;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const bool here = (std::abs(rays.origin_x[k] - middle.x()) <= reach) &
                      (std::abs(rays.origin_y[k] - middle.y()) <= reach) &
                      (std::abs(rays.origin_z[k] - middle.z()) <= reach);
    near &= here | (rays.active[k] == 0);
  }
  return near;
}

void RayTile::cast(const ExactRays& rays, const double* start_m, ExactHits& hits) const {
  impl_->cast(rays, start_m, hits);
}

void RayTile::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m, HitPacket& hits,
                   RayOrder order) const {
  impl_->cast(anchor_world_m, rays, start_m, hits, order);
}

void RayTile::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m,
                       Blocked& blocked, RayOrder order) const {
  impl_->occluded(anchor_world_m, rays, start_m, blocked, order);
}

double RayTile::distance(const Eigen::Vector3d& point_world_m, double nearest_m) const {
  const double to_met = nearest_triangle_m(impl_->scene, impl_->surfaces, false, point_world_m, nearest_m);
  return nearest_triangle_m(impl_->mesh_tree.get(), impl_->surfaces, true, point_world_m, to_met);
}

}  // namespace uwsim
