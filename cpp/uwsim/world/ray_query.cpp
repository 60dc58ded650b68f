#include "uwsim/world/ray_query.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

#include "uwsim/world/ray_terrain.h"

namespace uwsim {
namespace {

constexpr double kCompany = 8;  // times the reach, within which surfaces count as near each other

/// By how much more the tree's surfaces may be away than the true ones.
double room_m(const TileSurfaces& surfaces) { return 4 * surfaces.reach_m() + surfaces.clearance_m(); }

void query(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& point_world_m, double radius_m,
           RTCPointQueryFunction visit, void* user) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
  RTCPointQuery sphere{p.x(), p.y(), p.z(), 0, static_cast<float>(radius_m + room_m(surfaces))};
  rtcPointQuery(tree, &sphere, &context, visit, user);
}

struct Search {
  const TileSurfaces* surfaces;
  const TileRay* ray;
  double from_m, to_m;
  std::optional<LabelledHit> best;
};

bool try_primitive(RTCPointQueryFunctionArguments* args) {
  auto* search = static_cast<Search*>(args->userPtr);
  for_each_member(args->geomID, args->primID, [&](std::uint32_t member) {
    const auto hit = search->surfaces->meet(args->geomID, member, *search->ray);
    if (!hit || hit->distance_m < search->from_m || hit->distance_m > search->to_m) return;
    if (search->best && search->best->hit.distance_m <= hit->distance_m) return;
    search->best = {*hit, TileSurfaces::label(args->geomID)};
  });
  return false;
}

struct Company {
  const TileSurfaces* surfaces;
  std::uint32_t geometry;
  bool round;
  Corners corners;
  Eigen::AlignedBox3d box;
  bool found;
};

bool is_company(const Company& me, std::uint32_t geometry, std::uint32_t member) {
  Eigen::AlignedBox3d other;
  if (me.surfaces->is_round(geometry)) {
    const ShapeBounds limits = bounds(me.surfaces->shape(geometry, member));
    other = {limits.low_m, limits.high_m};
  } else {
    for (const Eigen::Vector3d& corner : me.surfaces->corners(geometry, member)) {
      // A neighbour, or itself: the search around rims takes care of these.
      if (geometry == me.geometry && std::ranges::find(me.corners, corner) != me.corners.end()) return false;
      other.extend(corner);
    }
  }
  return me.box.intersects(other);
}

bool find_company(RTCPointQueryFunctionArguments* args) {
  auto* me = static_cast<Company*>(args->userPtr);
  // Round shapes are exact in themselves; terrain is looked at when they are hit.
  if (me->round && (me->surfaces->is_round(args->geomID) || args->geomID <= kTerrain)) return false;
  for_each_member(args->geomID, args->primID,
                  [&](std::uint32_t member) { me->found = me->found || is_company(*me, args->geomID, member); });
  if (me->found) args->query->radius = 0;
  return me->found;
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
  double distance = nearest->distance_m;
  const auto try_triangle = [&](const Corners& t) {
    distance = std::min(distance, (closest_on_triangle(nearest->point_world_m, t) - nearest->point_world_m).norm());
  };
  if (nearest->meshes) {
    try_triangle(surfaces.mesh_corners(args->geomID, args->primID));
  } else if (!surfaces.is_round(args->geomID)) {
    for_each_member(args->geomID, args->primID,
                    [&](std::uint32_t member) { try_triangle(surfaces.corners(args->geomID, member)); });
  }
  if (!(distance < nearest->distance_m)) return false;
  nearest->distance_m = distance;
  // A hair wider than the double result, so that float rounding hides no nearer triangle.
  args->query->radius = static_cast<float>(distance * (1 + 1e-5) + room_m(surfaces));
  return true;
}

}  // namespace

std::optional<LabelledHit> first_hit_around(RTCSceneTy* tree, const TileSurfaces& surfaces,
                                            const Eigen::Vector3d& point_world_m, double radius_m, const TileRay& ray,
                                            double from_m, double to_m) {
  Search search{&surfaces, &ray, from_m, to_m, {}};
  query(tree, surfaces, point_world_m, radius_m, &try_primitive, &search);
  return search.best;
}

std::vector<std::uint8_t> crowded_members(RTCSceneTy* tree, const TileSurfaces& surfaces, Label label) {
  std::vector<std::uint8_t> crowded(surfaces.count(label));
  for (std::uint32_t k = 0; k < crowded.size(); ++k) {
    Company me{&surfaces, label, surfaces.is_round(label), {}, {}, false};
    if (me.round) {
      const ShapeBounds limits = bounds(surfaces.shape(label, k));
      me.box = {limits.low_m, limits.high_m};
    } else {
      me.corners = surfaces.corners(label, k);
      for (const Eigen::Vector3d& corner : me.corners) me.box.extend(corner);
    }
    const double radius = 0.5 * me.box.diagonal().norm();
    me.box.min().array() -= kCompany * surfaces.reach_m();
    me.box.max().array() += kCompany * surfaces.reach_m();
    query(tree, surfaces, me.box.center(), radius + kCompany * surfaces.reach_m(), &find_company, &me);
    crowded[k] = me.found ? 1 : 0;
  }
  return crowded;
}

double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
  RTCPointQuery query{p.x(), p.y(), p.z(), 0, static_cast<float>(nearest_m * (1 + 1e-5) + room_m(surfaces))};
  NearestTriangle nearest{&surfaces, meshes, point_world_m, nearest_m};
  rtcPointQuery(tree, &query, &context, &visit_triangle, &nearest);
  return nearest.distance_m;
}

}  // namespace uwsim
