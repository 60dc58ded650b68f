#include "uwsim/world/ray_tile.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "uwsim/world/ray_ask.h"
#include "uwsim/world/ray_float.h"
#include "uwsim/world/ray_geometry.h"
#include "uwsim/world/ray_query.h"
#include "uwsim/world/ray_terrain.h"
#include "uwsim/world/ray_walk.h"

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastSine = 1.7e-3;  // within 0.1 degree of tangency no one asks for more
constexpr int kTurns = 64;             // rims a ray may brush past before it is given up to float
constexpr std::size_t kFew = 16;       // so many surfaces near a cell are tried one by one
constexpr std::size_t kTogether = 4;   // packets; their heights come from memory while the next are cast

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

void set_all_missed(ExactHits& hits) {
  hits.distance_m.fill(kInfinity);
  hits.normal_x.fill(0);
  hits.normal_y.fill(0);
  hits.normal_z.fill(0);
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
  const RayKernels& kernels = ray_kernels();

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
        round.push_back({geometry, {}, surfaces.middle_m(), 2 * surfaces.reach_m()});
        for (std::uint32_t k = 0; k < surfaces.count(geometry); ++k) {
          round.back().shapes.push_back(surfaces.shape(geometry, k));
        }
        attach_round(device, scene, round.back());
      } else {
        (geometry > kTerrain ? attach_triangles : attach_terrain)(device, scene, surfaces, geometry);
      }
    }
    const auto& meshes = surfaces.contents().meshes;
    for (std::size_t k = 0; k < meshes.size(); ++k) attach_mesh(device, mesh_tree.get(), surfaces, k);
    commit(device, scene, triangles);
    commit(device, mesh_tree.get(), triangles);
    if (surfaces.count(TileSurfaces::kPlainTerrain) > 0) block = surfaces.terrain_block();
    crowded.resize(geometries);
    for (const TileContents::Share& share : surfaces.contents().solids) {
      crowded[share.label] = crowded_members(scene, surfaces, share.label);
    }
  }

  Eigen::Vector3d normal(const Named& named, const TileRay& ray) const {
    if (surfaces.is_round(named.geometry)) {
      const auto hit = surfaces.meet(named.geometry, named.primitive, ray);
      return hit ? hit->normal_world : Eigen::Vector3d(-ray.direction_world);
    }
    const Corners t = surfaces.corners(named.geometry, named.primitive);
    return (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized();
  }

  double sine(const Named& named, const TileRay& ray) const {
    if (surfaces.is_round(named.geometry)) return kLeastSine;  // of whatever else may be first
    return std::max(kLeastSine, std::abs(normal(named, ray).dot(ray.direction_world)));
  }

  /// How far from the point that Embree names the true hit may be.
  double room_m(double sine) const { return surfaces.error_m() * (1 + 1 / sine); }

  /// Of terrain and solid, what is first. Embree tells of a solid too early or not at all, by the rim's width, and of
  /// the terrain too early, or by lying under its twin not at all; then the ray goes on behind.
  void follow(const ExactRays& rays, std::size_t lane, const double* starts_m, std::optional<Named> named,
              TerrainWalk bed, ExactHits& hits) const {
    TileRay ray = ray_of(rays, lane);
    const double far_m = ray.far_m;
    for (int turn = 0; named && turn < kTurns; ++turn) {
      if (named->geometry <= kTerrain) {
        if (!bed.hit && named->distance_m >= bed.clear_to_m)
          bed = walk_terrain(surfaces, ray, std::max(0.0, named->distance_m));
      } else {
        const double room = room_m(sine(*named, ray));
        const Eigen::Vector3d point = ray.origin_world_m + named->distance_m * ray.direction_world;
        const auto hit = first_hit_around(scene, surfaces, point, room, ray, std::max(0.0, named->distance_m - room),
                                          named->distance_m + room);
        if (hit && !(bed.hit && bed.hit->distance_m <= hit->hit.distance_m)) {
          return set_hit_within(hits, lane, hit->hit, hit->label, far_m);
        }
      }
      if (bed.hit) ray.far_m = std::min(ray.far_m, bed.hit->distance_m + room_m(kLeastSine));
      named = ask_one(scene, surfaces, rays, lane, ray, named->distance_m, starts_m);
    }
    bed.hit ? set_hit_within(hits, lane, *bed.hit, kTerrain, far_m) : set_miss(hits, lane);
  }

  static void set_hit_within(ExactHits& hits, std::size_t lane, const TileHit& hit, Label label, double far_m) {
    hit.distance_m <= far_m ? set_hit(hits, lane, hit, label) : set_miss(hits, lane);
  }

  /// Embree's answer to a packet, and where the heights of its terrain triangles are.
  struct Answer {
    alignas(64) std::array<std::uint32_t, kPacketRays> geometry, primitive;
    alignas(64) std::array<float, kPacketRays> distance_m;
    TerrainPlaces places;
    ExactHits round;
    bool any_terrain;
    std::uint32_t low;  ///< lanes that do not start clearly above the terrain, one a bit
  };

  void find_low(const ExactRays& rays, const double* starts_m, Answer& answer) const {
    alignas(64) std::array<std::int32_t, kPacketRays> low;
    starts_m == nullptr ? kernels.find_low(block, lanes_of(rays), low.data()) : low.fill(-1);
    std::int32_t any = 0;
    for (std::size_t k = 0; k < kPacketRays; ++k) any |= low[k] &= rays.active[k];
    answer.low = 0;
    for (std::size_t k = 0; any != 0 && k < kPacketRays; ++k) answer.low |= static_cast<std::uint32_t>(low[k] & 1) << k;
  }

  void ask(RTCRayHit16& packet, const ExactRays& rays, const double* starts_m, Answer& answer) const {
    fill(surfaces, rays, starts_m, packet);
    answer.low = 0;
    if (block.heights_m != nullptr) find_low(rays, starts_m, answer);
    intersect(scene, {&surfaces, &rays, starts_m, surfaces.back_m(), &answer.round}, RayOrder::kCoherent,
              rays.active.data(), packet);
    alignas(64) std::array<std::uint32_t, kPacketRays> triangles;
    const int kinds = kernels.name_triangles({packet.hit.geomID, packet.hit.primID, packet.hit.u, packet.hit.v},
                                             TileSurfaces::kCrossedTerrain, TileSurfaces::kPlainTerrain,
                                             answer.primitive.data(), triangles.data(), answer.places.wanted);
    for (std::size_t k = 0; (kinds & 1) != 0 && k < kPacketRays; ++k) {
      if (packet.hit.geomID[k] != TileSurfaces::kCrossedTerrain) continue;
      triangles[k] = surfaces.plain_number(answer.primitive[k]);
      answer.places.wanted[k] = -1;
    }
    std::copy_n(packet.hit.geomID, kPacketRays, answer.geometry.begin());
    std::copy_n(packet.ray.tfar, kPacketRays, answer.distance_m.begin());
    answer.any_terrain = kinds != 0;
    if (answer.any_terrain) kernels.locate(block, triangles.data(), answer.places);
  }

  void conclude(const Answer& answer, const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
    alignas(64) std::array<std::int32_t, kPacketRays> met;
    if (answer.any_terrain) {
      kernels.solve(
          block, answer.places, lanes_of(rays),
          {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data(), met.data()});
    } else {
      met.fill(0);
      set_all_missed(hits);
    }
    std::uint32_t left = answer.low;  // lanes that are not done, one a bit
    const bool done = kernels.label(answer.geometry.data(), TileSurfaces::kPlainTerrain, met.data(), hits.label.data());
    for (std::size_t k = 0; !done && k < kPacketRays; ++k) {
      const bool open = answer.geometry[k] != RTC_INVALID_GEOMETRY_ID && hits.label[k] == kNothing;
      left |= static_cast<std::uint32_t>(open) << k;
    }
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      conclude_lane(answer, rays, starts_m, lane, met[lane] != 0, hits);
    }
  }

  void conclude_lane(const Answer& answer, const ExactRays& rays, const double* starts_m, std::size_t lane,
                     bool met_terrain, ExactHits& hits) const {
    const std::uint32_t geometry = answer.geometry[lane], primitive = answer.primitive[lane];
    const double start_m = starts_m != nullptr ? starts_m[lane] : 0;
    std::optional<Named> named;
    if (geometry != RTC_INVALID_GEOMETRY_ID)
      named = {geometry, primitive, start_m - surfaces.back_m() + double{answer.distance_m[lane]}};
    TerrainWalk bed;
    bed.clear_to_m = 0;
    if ((answer.low >> lane & 1) != 0) {
      bed = walk_terrain(surfaces, ray_of(rays, lane), start_m);
      if (bed.set_out) return follow(rays, lane, starts_m, named, bed, hits);
    }
    if (!named) return;
    if (geometry == TileSurfaces::kPlainTerrain && met_terrain) {
      hits.label[lane] = kTerrain;
    } else if (geometry == TileSurfaces::kCrossedTerrain && met_terrain && surfaces.company(primitive).size() <= kFew) {
      hits.label[lane] = kTerrain;
      yield_to_company(rays, lane, primitive, hits);
    } else if (surfaces.is_round(geometry) && crowded[geometry][primitive] == 0) {
      const ExactHits& round = answer.round;
      const Eigen::Vector3d normal(round.normal_x[lane], round.normal_y[lane], round.normal_z[lane]);
      set_hit_within(hits, lane, {round.distance_m[lane], normal, true}, TileSurfaces::label(geometry),
                     rays.far_m[lane]);
    } else {
      settle(rays, lane, starts_m, *named, bed, hits);
    }
  }

  void cast(const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
    RTCRayHit16 packet;
    Answer answer;
    fill_constants(packet);
    ask(packet, rays, starts_m, answer);
    conclude(answer, rays, starts_m, hits);
  }

  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
    RTCRayHit16 packet;
    std::array<Answer, kTogether> answers;
    fill_constants(packet);
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
      const std::size_t last = std::min(first + kTogether, rays.size());
      for (std::size_t k = first; k < last; ++k) ask(packet, rays[k], nullptr, answers[k - first]);
      for (std::size_t k = first; k < last; ++k) conclude(answers[k - first], rays[k], nullptr, hits[k]);
    }
  }

  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m, HitPacket& hits,
            RayOrder order) const {
    hits.settled.fill(0);
    if (starts_m != nullptr) return cast_float(scene, surfaces, anchor_world_m, rays, starts_m, nullptr, hits, order);
    RoundAnswer answer(anchor_world_m, rays);
    cast_float(scene, surfaces, anchor_world_m, rays, nullptr, &answer, hits, order);
    if (answer.rays.made) settle_round(answer, rays, hits);
  }

  /// Round hits that nothing else can be before are what double makes of them.
  void settle_round(const RoundAnswer& answer, const RayPacket& rays, HitPacket& hits) const {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::uint32_t geometry = hits.label[k];
      if (rays.active[k] == 0 || geometry <= kTerrain || !surfaces.is_round(geometry)) continue;
      if (crowded[geometry][answer.primitive[k]] == 0) hits.settled[k] = -1;
    }
  }

  /// Float may have taken terrain for first that something else is before by less than its error.
  void yield_to_company(const ExactRays& rays, std::size_t lane, std::uint32_t crossed_triangle,
                        ExactHits& hits) const {
    const TileRay ray = ray_of(rays, lane);
    for (const TileSurfaces::Member& other : surfaces.company(crossed_triangle)) {
      const auto hit = surfaces.meet(other.geometry, other.primitive, ray);
      if (!hit || hit->distance_m < 0 || hit->distance_m >= hits.distance_m[lane]) continue;
      set_hit(hits, lane, *hit, TileSurfaces::label(other.geometry));
    }
  }

  /// A hit on a solid's triangle, or on the terrain's twin not above the triangle that the ray then meets.
  void settle(const ExactRays& rays, std::size_t lane, const double* starts_m, const Named& named, TerrainWalk bed,
              ExactHits& hits) const {
    const TileRay ray = ray_of(rays, lane);
    if (named.geometry <= kTerrain) {
      bed = walk_terrain(surfaces, ray, std::max(0.0, named.distance_m));
      if (bed.hit && !bed.crossed) return set_hit_within(hits, lane, *bed.hit, kTerrain, ray.far_m);
    } else if (!surfaces.is_round(named.geometry) && crowded[named.geometry][named.primitive] == 0) {
      const auto hit = surfaces.meet(named.geometry, named.primitive, ray);
      if (hit && hit->clear_of_edges && hit->distance_m >= 0) {
        return set_hit_within(hits, lane, *hit, TileSurfaces::label(named.geometry), ray.far_m);
      }
    }
    follow(rays, lane, starts_m, named, bed, hits);
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

bool RayTile::is_near(std::span<const ExactRays> rays) const {
  const double* middle_m = impl_->surfaces.middle_m().data();
  for (const ExactRays& packet : rays) {
    if (!impl_->kernels.all_near(lanes_of(packet), middle_m, impl_->surfaces.diagonal_m())) return false;
  }
  return true;
}

void RayTile::cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const { impl_->cast(rays, hits); }

void RayTile::cast(const ExactRays& rays, const double* start_m, ExactHits& hits) const {
  impl_->cast(rays, start_m, hits);
}

void RayTile::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m, HitPacket& hits,
                   RayOrder order) const {
  impl_->cast(anchor_world_m, rays, start_m, hits, order);
}

void RayTile::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m,
                       Blocked& blocked, RayOrder order) const {
  occluded_float(impl_->scene, impl_->surfaces, anchor_world_m, rays, start_m, blocked, order);
}

double RayTile::distance(const Eigen::Vector3d& point_world_m, double nearest_m) const {
  const double to_met = nearest_triangle_m(impl_->scene, impl_->surfaces, false, point_world_m, nearest_m);
  return nearest_triangle_m(impl_->mesh_tree.get(), impl_->surfaces, true, point_world_m, to_met);
}

}  // namespace uwsim
