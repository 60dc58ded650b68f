#include "uwsim/world/ray_tile.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "uwsim/world/ray_float.h"
#include "uwsim/world/ray_geometry.h"
#include "uwsim/world/ray_query.h"

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastSine = 1.7e-3;  // within 0.1 degree of tangency no one asks for more
constexpr int kTurns = 64;             // rims a ray may brush past before it is given up to float
constexpr std::size_t kFew = 16;       // so many surfaces near a cell are tried one by one
constexpr std::size_t kTogether = 4;   // packets; their heights come from memory while the next are cast
constexpr float kFarthest = std::numeric_limits<float>::max();

/// What Embree names.
struct Named {
  std::uint32_t geometry, primitive;
  double distance_m;
};

TileRay ray_of(const ExactRays& rays, std::size_t lane) {
  return {{rays.origin_x[lane], rays.origin_y[lane], rays.origin_z[lane]},
          {rays.direction_x[lane], rays.direction_y[lane], rays.direction_z[lane]},
          rays.far_m[lane]};
}

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
        attach_triangles(device, scene, surfaces, geometry);
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

  std::optional<Named> cast_one(const ExactRays& rays, std::size_t lane, const TileRay& ray, double start_m,
                                double from_m, const double* starts_m) const {
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
    intersect(scene, {&surfaces, &rays, starts_m}, one);
    if (one.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return Named{one.hit.geomID, one.hit.primID, start_m + double{one.ray.tfar}};
  }

  /// The first of everything near a point; of terrain alone, where nothing else is near, without searching the tree.
  std::optional<LabelledHit> first_around(std::uint32_t geometry, const Eigen::Vector3d& point, double radius,
                                          const TileRay& ray, double from_m, double to_m) const {
    if (geometry == TileSurfaces::kPlainTerrain) {
      const TileSurfaces::Around around = surfaces.meet_terrain_around(point, radius, ray, from_m, to_m);
      if (around.plain) return around.hit ? std::optional(LabelledHit{*around.hit, kTerrain}) : std::nullopt;
    }
    return first_hit_around(scene, surfaces, point, radius, ray, from_m, to_m);
  }

  /// The true first hit of a ray of which Embree says where it may be at the earliest.
  void follow(const ExactRays& rays, std::size_t lane, const double* starts_m, Named named, ExactHits& hits) const {
    const TileRay ray = ray_of(rays, lane);
    const double start_m = starts_m ? starts_m[lane] : 0;
    for (int turn = 0; turn < kTurns; ++turn) {
      const double radius = 2 * surfaces.rim_m() * (1 + 1 / sine(named, ray));
      const Eigen::Vector3d point = ray.origin_world_m + named.distance_m * ray.direction_world;
      const double from_m = std::max(0.0, named.distance_m - radius), to_m = named.distance_m + radius;
      if (const auto hit = first_around(named.geometry, point, radius, ray, from_m, to_m)) {
        return set_hit_within(hits, lane, hit->hit, hit->label, ray.far_m);
      }
      const auto next = cast_one(rays, lane, ray, start_m, named.distance_m + 0.5 * radius, starts_m);
      if (!next) return set_miss(hits, lane);
      named = *next;
    }
    set_hit_within(hits, lane, {named.distance_m, normal(named, ray), false}, TileSurfaces::label(named.geometry),
                   ray.far_m);
  }

  static void set_hit_within(ExactHits& hits, std::size_t lane, const TileHit& hit, Label label, double far_m) {
    hit.distance_m <= far_m ? set_hit(hits, lane, hit, label) : set_miss(hits, lane);
  }

  /// What Embree does not change.
  static void fill_constants(RTCRayHit16& packet) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.ray.tnear[k] = 0;
      packet.ray.time[k] = 0;
      packet.ray.mask[k] = ~0u;
      packet.ray.id[k] = static_cast<unsigned>(k);
      packet.ray.flags[k] = 0;
    }
  }

  void fill(const ExactRays& rays, const double* starts_m, RTCRayHit16& packet) const {
    kernels.to_float(lanes_of(rays), surfaces.middle_m().data(),
                     {packet.ray.org_x, packet.ray.org_y, packet.ray.org_z, packet.ray.dir_x, packet.ray.dir_y,
                      packet.ray.dir_z, packet.ray.tfar});
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    if (starts_m == nullptr) return;
    const Eigen::Vector3d middle = surfaces.middle_m();
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.ray.org_x[k] = static_cast<float>(rays.origin_x[k] + starts_m[k] * rays.direction_x[k] - middle.x());
      packet.ray.org_y[k] = static_cast<float>(rays.origin_y[k] + starts_m[k] * rays.direction_y[k] - middle.y());
      packet.ray.org_z[k] = static_cast<float>(rays.origin_z[k] + starts_m[k] * rays.direction_z[k] - middle.z());
      packet.ray.tfar[k] = at_most_float((rays.far_m[k] - starts_m[k]) * (1 + 1e-6) + 1e-6);
    }
  }

  /// Embree's answer to a packet, and where the heights of its terrain triangles are.
  struct Answer {
    alignas(64) std::array<std::uint32_t, kPacketRays> geometry, primitive;
    alignas(64) std::array<float, kPacketRays> distance_m;
    TerrainPlaces places;
    ExactHits round;
    bool any_terrain;
  };

  void ask(RTCRayHit16& packet, const ExactRays& rays, const double* starts_m, Answer& answer) const {
    fill(rays, starts_m, packet);
    intersect(scene, {&surfaces, &rays, starts_m, &answer.round}, RayOrder::kCoherent, rays.active.data(), packet);
    alignas(64) std::array<std::uint32_t, kPacketRays> triangles;
    std::int32_t any = 0;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::int32_t plain = packet.hit.geomID[k] == TileSurfaces::kPlainTerrain ? -1 : 0;
      triangles[k] = packet.hit.primID[k] & static_cast<std::uint32_t>(plain);
      answer.places.wanted[k] = plain;
      any |= plain;
    }
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (packet.hit.geomID[k] != TileSurfaces::kCrossedTerrain) continue;
      triangles[k] = surfaces.plain_number(packet.hit.primID[k]);
      any = answer.places.wanted[k] = -1;
    }
    std::copy_n(packet.hit.geomID, kPacketRays, answer.geometry.begin());
    std::copy_n(packet.hit.primID, kPacketRays, answer.primitive.begin());
    std::copy_n(packet.ray.tfar, kPacketRays, answer.distance_m.begin());
    answer.any_terrain = any != 0;
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
    std::uint32_t left = 0;  // lanes that are not done, one a bit
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const std::uint32_t geometry = answer.geometry[k];
      const bool plain = (geometry == TileSurfaces::kPlainTerrain) & (met[k] != 0);
      hits.label[k] = plain ? kTerrain : kNothing;
      left |= static_cast<std::uint32_t>(!plain & (geometry != RTC_INVALID_GEOMETRY_ID)) << k;
    }
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      conclude_lane(answer, rays, starts_m, lane, met[lane] != 0, hits);
    }
  }

  void conclude_lane(const Answer& answer, const ExactRays& rays, const double* starts_m, std::size_t lane,
                     bool met_terrain, ExactHits& hits) const {
    const std::uint32_t geometry = answer.geometry[lane], primitive = answer.primitive[lane];
    if (geometry == TileSurfaces::kCrossedTerrain && met_terrain && surfaces.company(primitive).size() <= kFew) {
      hits.label[lane] = kTerrain;
      yield_to_company(rays, lane, primitive, hits);
    } else if (surfaces.is_round(geometry) && crowded[geometry][primitive] == 0 &&
               !under_terrain(rays, lane, answer.round.distance_m[lane])) {
      const ExactHits& round = answer.round;
      const Eigen::Vector3d normal(round.normal_x[lane], round.normal_y[lane], round.normal_z[lane]);
      set_hit_within(hits, lane, {round.distance_m[lane], normal, true}, TileSurfaces::label(geometry),
                     rays.far_m[lane]);
    } else {
      const double start_m = starts_m != nullptr ? starts_m[lane] : 0;
      settle(rays, lane, starts_m, {geometry, primitive, start_m + double{answer.distance_m[lane]}}, hits);
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
      const bool alone = crowded[geometry][answer.primitive[k]] == 0;
      if (alone && !under_terrain(answer.rays.exact, k, answer.hits.distance_m[k])) hits.settled[k] = -1;
    }
  }

  /// Then a ray from above has met the terrain before, if by less than float tells.
  bool under_terrain(const ExactRays& rays, std::size_t lane, double distance_m) const {
    const auto& terrain = surfaces.world().terrain();
    if (!terrain) return false;
    const TileRay ray = ray_of(rays, lane);
    const Eigen::Vector3d point = ray.origin_world_m + distance_m * ray.direction_world;
    return point.z() < terrain->height_at(point.x(), point.y());
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

  /// A hit on a solid's triangle, or not well inside one of plain terrain.
  void settle(const ExactRays& rays, std::size_t lane, const double* starts_m, const Named& named,
              ExactHits& hits) const {
    if (named.geometry > kTerrain && !surfaces.is_round(named.geometry) &&
        crowded[named.geometry][named.primitive] == 0) {
      const TileRay ray = ray_of(rays, lane);
      const auto hit = surfaces.meet(named.geometry, named.primitive, ray);
      if (hit && hit->clear_of_edges && hit->distance_m >= 0) {
        return set_hit_within(hits, lane, *hit, TileSurfaces::label(named.geometry), ray.far_m);
      }
    }
    follow(rays, lane, starts_m, named, hits);
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
