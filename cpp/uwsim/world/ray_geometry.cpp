#include "uwsim/world/ray_geometry.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

using GeometryOwner = std::unique_ptr<RTCGeometryTy, decltype(&rtcReleaseGeometry)>;

/// Triangles that share no vertices: each is widened by itself.
template <typename CornersOf>
void attach(RTCDevice device, RTCScene tree, std::size_t count, std::uint32_t geometry_id,
            const CornersOf& corners_of) {
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE), &rtcReleaseGeometry);
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
  rtcCommitGeometry(owner.get());
  rtcAttachGeometryByID(tree, owner.get(), geometry_id);
}

void round_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const ShapeBounds box = bounds(round.surfaces->shape(round.geometry, args->primID));
  const Eigen::Vector3d room = Eigen::Vector3d::Constant(2 * round.surfaces->reach_m());
  const Eigen::Vector3f low = (box.low_m - round.surfaces->middle_m() - room).cast<float>();
  const Eigen::Vector3f high = (box.high_m - round.surfaces->middle_m() + room).cast<float>();
  *args->bounds_o = {low.x(), low.y(), low.z(), 0, high.x(), high.y(), high.z(), 0};
}

struct Followed {
  TileRay ray;
  double start_m;
};

/// Ray k of a callback's packet in double: the exact one where there is one.
Followed followed(const RTCIntersectContext* context, RTCRayN* rays, unsigned n, unsigned k) {
  const auto& detail = *reinterpret_cast<const RayDetail*>(context + 1);
  if (detail.exact != nullptr) {
    const ExactRays& exact = *detail.exact;
    const unsigned lane = RTCRayN_id(rays, n, k);
    return {{{exact.origin_x[lane], exact.origin_y[lane], exact.origin_z[lane]},
             {exact.direction_x[lane], exact.direction_y[lane], exact.direction_z[lane]},
             0},
            detail.starts_m != nullptr ? detail.starts_m[lane] : 0};
  }
  const Eigen::Vector3d origin(RTCRayN_org_x(rays, n, k), RTCRayN_org_y(rays, n, k), RTCRayN_org_z(rays, n, k));
  const Eigen::Vector3d way(RTCRayN_dir_x(rays, n, k), RTCRayN_dir_y(rays, n, k), RTCRayN_dir_z(rays, n, k));
  return {{origin + detail.surfaces->middle_m(), way, 0}, 0};
}

void round_intersect(const RTCIntersectFunctionNArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const RoundShape& shape = round.surfaces->shape(round.geometry, args->primID);
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    const auto [ray, start_m] = followed(args->context, rays, args->N, k);
    const auto hit =
        first_hit(shape, ray.origin_world_m, ray.direction_world, start_m + double{RTCRayN_tnear(rays, args->N, k)},
                  start_m + double{RTCRayN_tfar(rays, args->N, k)});
    if (!hit) continue;
    RTCRayN_tfar(rays, args->N, k) = static_cast<float>(hit->distance_m - start_m);
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
  const RoundShape& shape = round.surfaces->shape(round.geometry, args->primID);
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    const auto [ray, start_m] = followed(args->context, args->ray, args->N, k);
    const bool met = first_hit(shape, ray.origin_world_m, ray.direction_world,
                               start_m + double{RTCRayN_tnear(args->ray, args->N, k)},
                               start_m + double{RTCRayN_tfar(args->ray, args->N, k)})
                         .has_value();
    if (met) RTCRayN_tfar(args->ray, args->N, k) = -std::numeric_limits<float>::infinity();
  }
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

struct NearestTriangle {
  const TileSurfaces* surfaces;
  bool meshes;
  Eigen::Vector3d point_world_m;
  double distance_m;
};

bool visit_triangle(RTCPointQueryFunctionArguments* args) {
  auto* nearest = static_cast<NearestTriangle*>(args->userPtr);
  const TileSurfaces& surfaces = *nearest->surfaces;
  if (!nearest->meshes && surfaces.is_round(args->geomID)) return false;
  const Corners t = nearest->meshes ? surfaces.mesh_corners(args->geomID, args->primID)
                                    : surfaces.corners(args->geomID, args->primID);
  const double distance = (closest_on_triangle(nearest->point_world_m, t) - nearest->point_world_m).norm();
  if (!(distance < nearest->distance_m)) return false;
  nearest->distance_m = distance;
  // A hair wider than the double result, so that float rounding hides no nearer triangle.
  args->query->radius = static_cast<float>(distance * (1 + 1e-5) + 4 * surfaces.reach_m());
  return true;
}

}  // namespace

void ReleaseDevice::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
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
  const bool plain = geometry == TileSurfaces::kPlainTerrain;
  attach(device, tree, surfaces.count(geometry), geometry, [&](std::uint32_t k) -> Corners {
    if (plain && surfaces.is_crossed(k)) {  // Embree leaves out what is not finite
      const auto nowhere = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      return {nowhere, nowhere, nowhere};
    }
    Corners corners = surfaces.corners(geometry, k);
    for (Eigen::Vector3d& corner : corners) corner -= middle;
    return widened(corners, surfaces.reach_m());
  });
}

void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh) {
  const TileContents::Share& share = surfaces.contents().meshes[mesh];
  attach(device, tree, share.members.size(), static_cast<std::uint32_t>(mesh), [&](std::uint32_t k) {
    Corners corners = surfaces.mesh_corners(mesh, k);
    for (Eigen::Vector3d& corner : corners) corner -= surfaces.middle_m();
    return corners;
  });
}

void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round) {
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER), &rtcReleaseGeometry);
  rtcSetGeometryUserPrimitiveCount(owner.get(), static_cast<unsigned>(round.surfaces->count(round.geometry)));
  rtcSetGeometryUserData(owner.get(), const_cast<RoundGeometry*>(&round));
  rtcSetGeometryBoundsFunction(owner.get(), &round_bounds, nullptr);
  rtcSetGeometryIntersectFunction(owner.get(), &round_intersect);
  rtcSetGeometryOccludedFunction(owner.get(), &round_occluded);
  rtcCommitGeometry(owner.get());
  rtcAttachGeometryByID(tree, owner.get(), round.geometry);
}

double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
  RTCPointQuery query{p.x(), p.y(), p.z(), 0, static_cast<float>(nearest_m * (1 + 1e-5) + 4 * surfaces.reach_m())};
  NearestTriangle nearest{&surfaces, meshes, point_world_m, nearest_m};
  rtcPointQuery(tree, &query, &context, &visit_triangle, &nearest);
  return nearest.distance_m;
}

}  // namespace uwsim
