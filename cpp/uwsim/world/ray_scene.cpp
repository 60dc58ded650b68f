#include "uwsim/world/ray_scene.h"

#include <embree3/rtcore.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

constexpr std::size_t kPacket = 16;
constexpr double kFarthestOrigin_m = 1e15;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Corners = std::array<Eigen::Vector3d, 3>;

Eigen::Vector3d middle_of(const World& world) {
  if (world.terrain()) {
    const Eigen::Vector2d middle = 0.5 * (world.terrain()->origin_m() + world.terrain()->far_corner_m());
    return {middle.x(), middle.y(), 0};
  }
  return world.solids().empty() ? Eigen::Vector3d::Zero().eval()
                                : world.solids().front()->mesh_world.vertices_m.front();
}

/// Closest point on a triangle (Ericson 2005, "Real-Time Collision Detection", 5.1.5); edges may have no length.
Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + d1 / (d1 - d3) * ab;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double along_bc = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 >= d3 && d5 >= d6 && along_bc > 0) return b + (d4 - d3) / along_bc * (c - b);
  const double whole = va + vb + vc;
  return whole > 0 ? Eigen::Vector3d(a + (vb * ab + vc * ac) / whole) : a;
}

}  // namespace

using Device = std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)>;
using Scene = std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)>;
using Geometry = std::unique_ptr<RTCGeometryTy, decltype(&rtcReleaseGeometry)>;

struct RayScene::Impl {
  World world;
  Eigen::Vector3d middle_world_m;  // float coordinates are relative to this
  Device device_owner;
  Scene scene_owner;
  RTCDevice device;
  RTCScene scene;

  explicit Impl(const World& source)
      : world(source),
        middle_world_m(middle_of(source)),
        device_owner(rtcNewDevice("verbose=0"), &rtcReleaseDevice),
        scene_owner(rtcNewScene(device_owner.get()), &rtcReleaseScene),
        device(device_owner.get()),
        scene(scene_owner.get()) {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // without it, rays through shared edges leak
    if (world.terrain())
      attach(world.terrain()->nx() * world.terrain()->ny(), world.terrain()->triangle_count(), kTerrain);
    for (std::size_t k = 0; k < world.solids().size(); ++k) {
      const TriangleMesh& mesh = world.solids()[k]->mesh_world;
      attach(mesh.vertices_m.size(), mesh.triangles.size(), static_cast<Label>(kTerrain + 1 + k));
    }
    rtcCommitScene(scene);
    require_built();
  }

  /// Embree does not throw: it would go on with a world that has holes.
  void require_built() const {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return;
    std::size_t triangles = world.terrain() ? world.terrain()->triangle_count() : 0;
    for (const auto& solid : world.solids()) triangles += solid->mesh_world.triangles.size();
    require(
        false, "world.triangles", triangles,
        error == RTC_ERROR_OUT_OF_MEMORY ? "not enough memory to build their tree" : "Embree cannot build their tree");
  }

  Eigen::Vector3d vertex(Label label, std::size_t index) const {
    return label == kTerrain ? world.terrain()->vertex(index)
                             : world.solids()[label - kTerrain - 1]->mesh_world.vertices_m[index];
  }

  Triangle triangle(Label label, std::size_t index) const {
    return label == kTerrain ? world.terrain()->triangle(index)
                             : world.solids()[label - kTerrain - 1]->mesh_world.triangles[index];
  }

  Corners corners(Label label, std::size_t index) const {
    const Triangle t = triangle(label, index);
    return {vertex(label, t[0]), vertex(label, t[1]), vertex(label, t[2])};
  }

  /// Embree's geometry id is the label.
  void attach(std::size_t vertex_count, std::size_t triangle_count, Label label) {
    const Geometry owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE), &rtcReleaseGeometry);
    RTCGeometry geometry = owner.get();
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), vertex_count));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangle_count));
    require_built();
    for (std::size_t k = 0; k < vertex_count; ++k) {
      Eigen::Map<Eigen::Vector3f>(vertices + 3 * k) = (vertex(label, k) - middle_world_m).cast<float>();
    }
    for (std::size_t k = 0; k < triangle_count; ++k) {
      const Triangle t = triangle(label, k);
      std::copy(t.begin(), t.end(), indices + 3 * k);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, label);
  }

  /// Embree's float distance errs by up to 1e-2 m far from the origin; its choice of triangle is good.
  RayHit resolve(const Ray& ray, unsigned geometry, unsigned primitive, float float_distance) const {
    if (geometry == RTC_INVALID_GEOMETRY_ID) return {kInfinity, Eigen::Vector3f::Zero(), kNothing};
    const auto label = static_cast<Label>(geometry);
    const Corners t = corners(label, primitive);
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    const double along = normal.dot(ray.direction_world);
    // Within 0.1 degree of tangency the plane says less about the distance than Embree does.
    const double distance =
        std::abs(along) < 1.7e-3 ? double{float_distance} : normal.dot(t[0] - ray.origin_world_m) / along;
    return {std::max(0.0, distance), normal.cast<float>(), label};
  }

  void cast_range(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    alignas(64) RTCRayHit16 packet;
    alignas(64) std::array<int, kPacket> valid;
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
      const std::size_t count = std::min(kPacket, rays.size() - first);
      for (std::size_t lane = 0; lane < kPacket; ++lane) {
        const Ray& ray = rays[first + std::min(lane, count - 1)];
        const Eigen::Vector3d from_middle = ray.origin_world_m - middle_world_m;
        // Past what a float holds, Embree ends the process; nothing is there to be met either.
        const bool sane = from_middle.cwiseAbs().maxCoeff() < kFarthestOrigin_m && ray.direction_world.allFinite();
        valid[lane] = lane < count && sane ? -1 : 0;
        const Eigen::Vector3f origin = from_middle.cast<float>();
        packet.ray.org_x[lane] = origin.x();
        packet.ray.org_y[lane] = origin.y();
        packet.ray.org_z[lane] = origin.z();
        packet.ray.dir_x[lane] = static_cast<float>(ray.direction_world.x());
        packet.ray.dir_y[lane] = static_cast<float>(ray.direction_world.y());
        packet.ray.dir_z[lane] = static_cast<float>(ray.direction_world.z());
        packet.ray.tnear[lane] = 0;
        packet.ray.tfar[lane] = static_cast<float>(max_range_m);
        packet.ray.time[lane] = 0;
        packet.ray.mask[lane] = ~0u;
        packet.ray.flags[lane] = 0;
        packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect16(valid.data(), scene, &context, &packet);
      for (std::size_t lane = 0; lane < count; ++lane) {
        hits[first + lane] =
            resolve(rays[first + lane], packet.hit.geomID[lane], packet.hit.primID[lane], packet.ray.tfar[lane]);
      }
    }
  }

  RTCRay16 rays_of(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays) const {
    RTCRay16 out;
    const Eigen::Vector3f shift = (anchor_world_m - middle_world_m).cast<float>();
    for (std::size_t lane = 0; lane < kPacket; ++lane) {
      out.org_x[lane] = shift.x() + rays.origin_x[lane];
      out.org_y[lane] = shift.y() + rays.origin_y[lane];
      out.org_z[lane] = shift.z() + rays.origin_z[lane];
      out.dir_x[lane] = rays.direction_x[lane];
      out.dir_y[lane] = rays.direction_y[lane];
      out.dir_z[lane] = rays.direction_z[lane];
      out.tnear[lane] = rays.near_m[lane];
      out.tfar[lane] = rays.far_m[lane];
      out.time[lane] = 0;
      out.mask[lane] = ~0u;
      out.flags[lane] = 0;
    }
    return out;
  }

  static RTCIntersectContext context_for(RayOrder order) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (order == RayOrder::kCoherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
  }

  void cast_packet(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
                   RayOrder order) const {
    RTCIntersectContext context = context_for(order);
    RTCRayHit16 packet;
    packet.ray = rays_of(anchor_world_m, rays);
    for (std::size_t lane = 0; lane < kPacket; ++lane) packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect16(rays.active.data(), scene, &context, &packet);
    for (std::size_t lane = 0; lane < kPacket; ++lane) {
      const bool met = packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      hits.distance_m[lane] = met ? packet.ray.tfar[lane] : std::numeric_limits<float>::infinity();
      hits.u[lane] = packet.hit.u[lane];
      hits.v[lane] = packet.hit.v[lane];
      hits.normal_x[lane] = packet.hit.Ng_x[lane];
      hits.normal_y[lane] = packet.hit.Ng_y[lane];
      hits.normal_z[lane] = packet.hit.Ng_z[lane];
      hits.label[lane] = met ? packet.hit.geomID[lane] : kNothing;
      hits.primitive[lane] = packet.hit.primID[lane];
    }
  }

  void occluded_packet(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                       std::array<std::int32_t, kPacket>& blocked, RayOrder order) const {
    RTCIntersectContext context = context_for(order);
    RTCRay16 packet = rays_of(anchor_world_m, rays);
    rtcOccluded16(rays.active.data(), scene, &context, &packet);
    for (std::size_t lane = 0; lane < kPacket; ++lane) {  // Embree marks what is blocked by tfar = -inf
      blocked[lane] = packet.tfar[lane] < 0 ? rays.active[lane] : 0;
    }
  }

  struct Query {
    const Impl* scene;
    Eigen::Vector3d point_world_m;
    double distance_m;
  };

  static bool visit_triangle(RTCPointQueryFunctionArguments* args) {
    auto* query = static_cast<Query*>(args->userPtr);
    const Corners t = query->scene->corners(static_cast<Label>(args->geomID), args->primID);
    const double distance = (closest_on_triangle(query->point_world_m, t) - query->point_world_m).norm();
    if (!(distance < query->distance_m)) return false;
    query->distance_m = distance;
    // The search radius stays a hair wider than the double result, so that float rounding hides no nearer triangle.
    args->query->radius = static_cast<float>(distance * (1 + 1e-5) + 1e-4);
    return true;
  }

  double distance_to(const Eigen::Vector3d& point_world_m) const {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const Eigen::Vector3f p = (point_world_m - middle_world_m).cast<float>();
    RTCPointQuery query{p.x(), p.y(), p.z(), 0, std::numeric_limits<float>::infinity()};
    Query state{this, point_world_m, kInfinity};
    rtcPointQuery(scene, &query, &context, &Impl::visit_triangle, &state);
    return state.distance_m;
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

void RayScene::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
                    RayOrder order) const {
  impl_->cast_packet(anchor_world_m, rays, hits, order);
}

void RayScene::occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                        std::array<std::int32_t, kPacketRays>& blocked, RayOrder order) const {
  impl_->occluded_packet(anchor_world_m, rays, blocked, order);
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
