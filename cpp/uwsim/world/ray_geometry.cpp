#include "uwsim/world/ray_geometry.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// Triangles that share no vertices: each is widened by itself.
template <typename CornersOf>
GeometryOwner triangles(RTCDevice device, std::size_t count, const CornersOf& corners_of) {
  GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  auto* vertex = static_cast<float*>(
      rtcSetNewGeometryBuffer(owner.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
  auto* index = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      owner.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
  require(vertex != nullptr && index != nullptr, "world.triangles", count, "not enough memory for them");
  for (std::size_t k = 0; k < count; ++k) {
    for (const Eigen::Vector3d& corner : corners_of(static_cast<std::uint32_t>(k))) {
      for (int axis = 0; axis < 3; ++axis) *vertex++ = static_cast<float>(corner(axis));
    }
  }
  for (std::size_t k = 0; k < 3 * count; ++k) index[k] = static_cast<std::uint32_t>(k);
  return owner;
}

void attach(RTCScene tree, RTCGeometry geometry, std::uint32_t geometry_id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(tree, geometry, geometry_id);
}

/// What Embree passes to the callbacks of round geometries.
struct CastContext {
  RTCIntersectContext embree;
  RayDetail detail;

  CastContext(const RayDetail& of_rays, RayOrder order) : detail(of_rays) {
    static_assert(offsetof(CastContext, detail) == sizeof(RTCIntersectContext));
    rtcInitIntersectContext(&embree);
    if (order == RayOrder::kCoherent) embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
};

/// Rays that are not solved again in double pass what widening added to triangles.
void pass_rims(const RTCFilterFunctionNArguments* args) {
  if (detail_of(args->context).exact != nullptr) return;
  const auto& surfaces = *static_cast<const TileSurfaces*>(args->geometryUserPtr);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    const Eigen::Vector3d origin(RTCRayN_org_x(args->ray, args->N, k), RTCRayN_org_y(args->ray, args->N, k),
                                 RTCRayN_org_z(args->ray, args->N, k));
    const Eigen::Vector3d way(RTCRayN_dir_x(args->ray, args->N, k), RTCRayN_dir_y(args->ray, args->N, k),
                              RTCRayN_dir_z(args->ray, args->N, k));
    const Eigen::Vector3d point = surfaces.middle_m() + origin + double{RTCRayN_tfar(args->ray, args->N, k)} * way;
    const Eigen::Vector3d normal(RTCHitN_Ng_x(args->hit, args->N, k), RTCHitN_Ng_y(args->hit, args->N, k),
                                 RTCHitN_Ng_z(args->hit, args->N, k));
    const Corners corners =
        surfaces.corners(RTCHitN_geomID(args->hit, args->N, k), RTCHitN_primID(args->hit, args->N, k));
    const double sine = std::abs(normal.stableNormalized().dot(way));
    // Float's error along the ray grows with its length over the triangle.
    const double room_m = surfaces.error_m() * (1 + 0.05 / sine);
    if ((closest_on_triangle(point, corners) - point).norm() > room_m) args->valid[k] = 0;
  }
}

void round_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const ShapeBounds box = bounds(round.shapes[args->primID]);
  const Eigen::Vector3d room = Eigen::Vector3d::Constant(round.room_m);
  const Eigen::Vector3f low = (box.low_m - round.middle_m - room).cast<float>();
  const Eigen::Vector3f high = (box.high_m - round.middle_m + room).cast<float>();
  *args->bounds_o = {low.x(), low.y(), low.z(), 0, high.x(), high.y(), high.z(), 0};
}

/// A callback's rays in double: the exact ones where there are any.
class CallbackRays {
 public:
  CallbackRays(const RTCIntersectContext* context, RTCRayN* rays, unsigned n)
      : detail_(detail_of(context)),
        exact_(detail_.exact == nullptr && detail_.late != nullptr ? &detail_.late->get() : detail_.exact),
        rays_(rays),
        n_(n) {}

  double start_m(unsigned k) const {
    const bool late = exact_ != nullptr && detail_.starts_m != nullptr;
    return (late ? detail_.starts_m[RTCRayN_id(rays_, n_, k)] : 0) - detail_.back_m;
  }
  double near_m(unsigned k) const { return std::max(0.0, start_m(k) + double{RTCRayN_tnear(rays_, n_, k)}); }
  double far_m(unsigned k) const { return start_m(k) + double{RTCRayN_tfar(rays_, n_, k)}; }

  Eigen::Vector3d origin_world_m(unsigned k) const {
    if (exact_ == nullptr) {
      return Eigen::Vector3d(RTCRayN_org_x(rays_, n_, k), RTCRayN_org_y(rays_, n_, k), RTCRayN_org_z(rays_, n_, k)) +
             detail_.surfaces->middle_m();
    }
    const unsigned lane = RTCRayN_id(rays_, n_, k);
    return {exact_->origin_x[lane], exact_->origin_y[lane], exact_->origin_z[lane]};
  }

  Eigen::Vector3d direction_world(unsigned k) const {
    if (exact_ == nullptr) {
      return {RTCRayN_dir_x(rays_, n_, k), RTCRayN_dir_y(rays_, n_, k), RTCRayN_dir_z(rays_, n_, k)};
    }
    const unsigned lane = RTCRayN_id(rays_, n_, k);
    return {exact_->direction_x[lane], exact_->direction_y[lane], exact_->direction_z[lane]};
  }

  std::optional<ShapeHit> meet(const RoundShape& shape, unsigned k) const {
    return first_hit(shape, origin_world_m(k), direction_world(k), near_m(k), far_m(k));
  }

  void keep(unsigned k, const ShapeHit& hit) const {
    if (detail_.round_hits == nullptr) return;
    const unsigned lane = RTCRayN_id(rays_, n_, k);
    detail_.round_hits->distance_m[lane] = hit.distance_m;
    detail_.round_hits->normal_x[lane] = hit.normal_world.x();
    detail_.round_hits->normal_y[lane] = hit.normal_world.y();
    detail_.round_hits->normal_z[lane] = hit.normal_world.z();
  }

  /// Takes the rays out of `valid` that pass the shape by. A full packet's lanes are in order.
  void leave_out_misses(const RoundShape& shape, const int* valid, std::int32_t* left) const {
    std::copy_n(valid, n_, left);
    if (n_ != kPacketRays) return;
    ExactRays converted;
    if (exact_ == nullptr) convert(converted);
    std::array<std::int32_t, kPacketRays> passes;
    static const RayKernels& kernels = ray_kernels();
    kernels.may_meet_round(lanes_of(exact_ != nullptr ? *exact_ : converted), shape.ends[0].point_world_m.data(),
                           shape.axis.data(), shape.radius_m, passes.data());
    for (std::size_t k = 0; k < kPacketRays; ++k) left[k] &= passes[k];
  }

 private:
  void convert(ExactRays& out) const {
    const Eigen::Vector3d& middle = detail_.surfaces->middle_m();
    for (unsigned k = 0; k < kPacketRays; ++k) {
      out.origin_x[k] = RTCRayN_org_x(rays_, n_, k) + middle.x();
      out.origin_y[k] = RTCRayN_org_y(rays_, n_, k) + middle.y();
      out.origin_z[k] = RTCRayN_org_z(rays_, n_, k) + middle.z();
      out.direction_x[k] = RTCRayN_dir_x(rays_, n_, k);
      out.direction_y[k] = RTCRayN_dir_y(rays_, n_, k);
      out.direction_z[k] = RTCRayN_dir_z(rays_, n_, k);
    }
  }

  const RayDetail& detail_;
  const ExactRays* exact_;
  RTCRayN* rays_;
  unsigned n_;
};

void round_intersect(const RTCIntersectFunctionNArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const RoundShape& shape = round.shapes[args->primID];
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  const CallbackRays callback(args->context, rays, args->N);
  std::array<std::int32_t, kPacketRays> left;
  callback.leave_out_misses(shape, args->valid, left.data());
  for (unsigned k = 0; k < args->N; ++k) {
    if (left[k] == 0) continue;
    const auto hit = callback.meet(shape, k);
    if (!hit) continue;
    callback.keep(k, *hit);
    RTCRayN_tfar(rays, args->N, k) = static_cast<float>(hit->distance_m - callback.start_m(k));
    RTCHitN_Ng_x(hits, args->N, k) = static_cast<float>(hit->normal_world.x());
    RTCHitN_Ng_y(hits, args->N, k) = static_cast<float>(hit->normal_world.y());
    RTCHitN_Ng_z(hits, args->N, k) = static_cast<float>(hit->normal_world.z());
    RTCHitN_u(hits, args->N, k) = RTCHitN_v(hits, args->N, k) = 0;
    RTCHitN_primID(hits, args->N, k) = args->primID;
    RTCHitN_geomID(hits, args->N, k) = args->geomID;
    RTCHitN_instID(hits, args->N, k, 0) = args->context->instID[0];
  }
}

void round_occluded(const RTCOccludedFunctionNArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const RoundShape& shape = round.shapes[args->primID];
  const CallbackRays callback(args->context, args->ray, args->N);
  std::array<std::int32_t, kPacketRays> left;
  callback.leave_out_misses(shape, args->valid, left.data());
  for (unsigned k = 0; k < args->N; ++k) {
    if (left[k] == 0 || !callback.meet(shape, k)) continue;
    RTCRayN_tfar(args->ray, args->N, k) = -std::numeric_limits<float>::infinity();
  }
}

}  // namespace

const RayDetail& detail_of(const RTCIntersectContext* context) {
  return reinterpret_cast<const CastContext*>(context)->detail;
}

const ExactRays& LateRays::get() {
  if (made) return exact;
  made = true;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3d from(rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]);
    const Eigen::Vector3d way(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
    const Eigen::Vector3d origin = anchor_world_m + from, unit = way.normalized();
    exact.origin_x[k] = origin.x(), exact.origin_y[k] = origin.y(), exact.origin_z[k] = origin.z();
    exact.direction_x[k] = unit.x(), exact.direction_y[k] = unit.y(), exact.direction_z[k] = unit.z();
    exact.far_m[k] = rays.far_m[k];
    exact.active[k] = rays.active[k];
  }
  return exact;
}

void ReleaseDevice::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
void ReleaseGeometry::operator()(RTCGeometryTy* geometry) const { rtcReleaseGeometry(geometry); }
void ReleaseScene::operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }

RayDevice make_ray_device() { return RayDevice(rtcNewDevice("verbose=0")); }

RayTree make_ray_tree(RTCDeviceTy* device, bool robust) {
  RayTree tree(rtcNewScene(device));
  if (robust) rtcSetSceneFlags(tree.get(), RTC_SCENE_FLAG_ROBUST);
  return tree;
}

void commit(RTCDeviceTy* device, RTCSceneTy* tree, std::size_t triangles) {
  rtcCommitScene(tree);
  const RTCError error = rtcGetDeviceError(device);
  require(
      error == RTC_ERROR_NONE, "world.triangles", triangles,
      error == RTC_ERROR_OUT_OF_MEMORY ? "not enough memory to build their tree" : "Embree cannot build their tree");
}

void attach_triangles(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::uint32_t geometry) {
  const Eigen::Vector3d middle = surfaces.middle_m();
  const GeometryOwner owner = triangles(device, surfaces.count(geometry), [&](std::uint32_t k) {
    Corners corners = surfaces.corners(geometry, k);
    for (Eigen::Vector3d& corner : corners) corner -= middle;
    return widened(corners, surfaces.rim_m());
  });
  rtcSetGeometryUserData(owner.get(), const_cast<TileSurfaces*>(&surfaces));
  rtcSetGeometryIntersectFilterFunction(owner.get(), &pass_rims);
  rtcSetGeometryOccludedFilterFunction(owner.get(), &pass_rims);
  attach(tree, owner.get(), geometry);
}

void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh) {
  const TileContents::Share& share = surfaces.contents().meshes[mesh];
  const GeometryOwner owner = triangles(device, share.members.size(), [&](std::uint32_t k) {
    Corners corners = surfaces.mesh_corners(mesh, k);
    for (Eigen::Vector3d& corner : corners) corner -= surfaces.middle_m();
    return corners;
  });
  attach(tree, owner.get(), static_cast<std::uint32_t>(mesh));
}

void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round) {
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(owner.get(), static_cast<unsigned>(round.shapes.size()));
  rtcSetGeometryUserData(owner.get(), const_cast<RoundGeometry*>(&round));
  rtcSetGeometryBoundsFunction(owner.get(), &round_bounds, nullptr);
  rtcSetGeometryIntersectFunction(owner.get(), &round_intersect);
  rtcSetGeometryOccludedFunction(owner.get(), &round_occluded);
  attach(tree, owner.get(), round.geometry);
}

namespace {

/// Where Embree splits packets, for lack of AVX-512, it looks at idle lanes too, and Debian's ends the process over one
/// that is not finite.
void calm_idle(const std::int32_t* active, RTCRay16& rays) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const bool idle = active[k] == 0;
    rays.org_x[k] = idle ? 0.0f : rays.org_x[k];
    rays.org_y[k] = idle ? 0.0f : rays.org_y[k];
    rays.org_z[k] = idle ? 0.0f : rays.org_z[k];
    rays.dir_x[k] = idle ? 0.0f : rays.dir_x[k];
    rays.dir_y[k] = idle ? 0.0f : rays.dir_y[k];
    rays.dir_z[k] = idle ? 1.0f : rays.dir_z[k];
    rays.tnear[k] = idle ? 0.0f : rays.tnear[k];
    rays.tfar[k] = idle ? 0.0f : rays.tfar[k];
  }
}

}  // namespace

void intersect(RTCSceneTy* tree, const RayDetail& detail, RayOrder order, const std::int32_t* active,
               RTCRayHit16& packet) {
  calm_idle(active, packet.ray);
  CastContext context(detail, order);
  rtcIntersect16(active, tree, &context.embree, &packet);
}

void intersect(RTCSceneTy* tree, const RayDetail& detail, RTCRayHit& ray) {
  CastContext context(detail, RayOrder::kIncoherent);
  rtcIntersect1(tree, &context.embree, &ray);
}

void occluded(RTCSceneTy* tree, const RayDetail& detail, RayOrder order, const std::int32_t* active, RTCRay16& packet) {
  calm_idle(active, packet);
  CastContext context(detail, order);
  rtcOccluded16(active, tree, &context.embree, &packet);
}

}  // namespace uwsim
