#include "uwsim/rays/embree_tree.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "uwsim/core/check.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/widened_triangle.h"

namespace uwsim {
namespace {

/// Adds triangles that do not share vertices, because each is widened separately.
template <typename CornersOf>
GeometryOwner separate_triangles(RTCDevice device, std::size_t count, const CornersOf& corners_of) {
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

Corners about(const Eigen::Vector3d& middle_m, Corners corners) {
  for (Eigen::Vector3d& corner : corners) corner -= middle_m;
  return corners;
}

/// Embree's filter for rays that are not recomputed in double: discards hits on the margins by which triangles were
/// widened.
void discard_widened_edges(const RTCFilterFunctionNArguments* args) {
  if (detail_of(args->context).exact != nullptr) return;
  const auto& triangles = *static_cast<const WidenedTriangles*>(args->geometryUserPtr);
  const TileSurfaces& surfaces = triangles.surfaces;
  for (unsigned k = 0; k < args->N; ++k) {
    if (args->valid[k] == 0) continue;
    const std::uint32_t primitive = RTCHitN_primID(args->hit, args->N, k);
    const float u = RTCHitN_u(args->hit, args->N, k), v = RTCHitN_v(args->hit, args->N, k);
    if (std::min({u, v, 1 - u - v}) > triangles.margin[primitive]) continue;
    const Eigen::Vector3d origin(RTCRayN_org_x(args->ray, args->N, k), RTCRayN_org_y(args->ray, args->N, k),
                                 RTCRayN_org_z(args->ray, args->N, k));
    const Eigen::Vector3d direction(RTCRayN_dir_x(args->ray, args->N, k), RTCRayN_dir_y(args->ray, args->N, k),
                                    RTCRayN_dir_z(args->ray, args->N, k));
    const Eigen::Vector3d point =
        surfaces.middle_m() + origin + double{RTCRayN_tfar(args->ray, args->N, k)} * direction;
    const Eigen::Vector3d normal(RTCHitN_Ng_x(args->hit, args->N, k), RTCHitN_Ng_y(args->hit, args->N, k),
                                 RTCHitN_Ng_z(args->hit, args->N, k));
    const Corners corners = surfaces.corners(RTCHitN_geomID(args->hit, args->N, k), primitive);
    const double sine = std::abs(normal.stableNormalized().dot(direction));
    const double outside_m = (closest_on_triangle(point, corners) - point).norm();
    if (outside_m > surfaces.tolerances().picture_edge_m(sine)) args->valid[k] = 0;
  }
}

}  // namespace

void ReleaseDevice::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
void ReleaseGeometry::operator()(RTCGeometryTy* geometry) const { rtcReleaseGeometry(geometry); }
void ReleaseTree::operator()(RTCSceneTy* tree) const { rtcReleaseScene(tree); }

RayDevice make_ray_device() {
  const InstructionSet chosen = chosen_instruction_set();
  std::string settings = "verbose=0";
  if (chosen != InstructionSet::best) {
    settings += std::string(",isa=") + (chosen == InstructionSet::portable ? "sse2" : instruction_set_name(chosen));
  }
  RayDevice device(rtcNewDevice(settings.c_str()));
  if (device == nullptr) throw std::bad_alloc();  // Embree 4 would read it; its settings are known to be valid
  return device;
}

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

void attach(RTCSceneTy* tree, const GeometryOwner& geometry, std::uint32_t geometry_id) {
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(tree, geometry.get(), geometry_id);
}

void attach_triangles(RTCDeviceTy* device, RTCSceneTy* tree, std::uint32_t geometry, WidenedTriangles& triangles) {
  const TileSurfaces& surfaces = triangles.surfaces;
  triangles.margin.reserve(surfaces.count(geometry));
  const GeometryOwner owner = separate_triangles(device, surfaces.count(geometry), [&](std::uint32_t k) {
    const Corners corners = about(surfaces.middle_m(), surfaces.corners(geometry, k));
    const Corners wide = widened(corners, surfaces.tolerances().widening_m);
    triangles.margin.push_back(margin_within(wide, corners));
    return wide;
  });
  rtcSetGeometryUserData(owner.get(), &triangles);
  rtcSetGeometryIntersectFilterFunction(owner.get(), &discard_widened_edges);
  rtcSetGeometryOccludedFilterFunction(owner.get(), &discard_widened_edges);
  attach(tree, owner, geometry);
}

void attach_mesh(RTCDeviceTy* device, RTCSceneTy* tree, const TileSurfaces& surfaces, std::size_t mesh) {
  const std::size_t count = surfaces.contents().meshes[mesh].members.size();
  const GeometryOwner owner = separate_triangles(
      device, count, [&](std::uint32_t k) { return about(surfaces.middle_m(), surfaces.mesh_corners(mesh, k)); });
  attach(tree, owner, static_cast<std::uint32_t>(mesh));
}

}  // namespace uwsim
