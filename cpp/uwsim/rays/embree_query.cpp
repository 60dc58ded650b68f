#include "uwsim/rays/embree_query.h"

#include <algorithm>

#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_terrain.h"
#include "uwsim/rays/triangle_distance.h"

namespace uwsim {
namespace {

void query(RTCSceneTy* tree, const TileSurfaces& surfaces, const Eigen::Vector3d& point_world_m, double radius_m,
           RTCPointQueryFunction visit, void* user) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
  RTCPointQuery sphere{p.x(), p.y(), p.z(), 0, static_cast<float>(radius_m + surfaces.tolerances().search_margin_m)};
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

/// The state of the search for other surfaces near a triangle or shape of a solid.
struct Neighbourhood {
  const TileSurfaces* surfaces;
  std::uint32_t geometry;
  bool round;
  Corners corners;          // of a triangle
  Eigen::AlignedBox3d box;  // including the margin
  bool crowded;
};

bool comes_near(const Neighbourhood& own, const TileMember& other) {
  if (!own.box.intersects(own.surfaces->box_of(other))) return false;
  if (own.round || own.surfaces->is_round(other.geometry)) return true;
  const Corners corners = own.surfaces->corners(other.geometry, other.primitive);
  if (other.geometry == own.geometry) {
    // Skip the triangle itself and its neighbours: hits near shared edges are searched among all adjacent triangles
    // anyway.
    for (const Eigen::Vector3d& corner : corners) {
      if (std::ranges::find(own.corners, corner) != own.corners.end()) return false;
    }
  }
  // The boxes of slanted triangles may overlap even if the triangles are far apart, so this computes the true distance.
  // Only triangles closer to each other than the widening count as crowded.
  return closer_than(own.corners, corners, own.surfaces->tolerances().widening_m);
}

bool visit_neighbour(RTCPointQueryFunctionArguments* args) {
  auto* own = static_cast<Neighbourhood*>(args->userPtr);
  // Round shapes are exact among themselves; terrain is handled where it is hit.
  if (own->round && (own->surfaces->is_round(args->geomID) || TileSurfaces::is_terrain(args->geomID))) return false;
  for_each_member(args->geomID, args->primID, [&](std::uint32_t member) {
    own->crowded = own->crowded || comes_near(*own, {args->geomID, member});
  });
  if (own->crowded) args->query->radius = 0;
  return own->crowded;
}

struct NearestTriangle {
  const TileSurfaces* surfaces;
  bool meshes;
  Eigen::Vector3d point_world_m;
  double distance_m;
};

/// Returns a radius slightly larger than the distance, so that float rounding does not hide a nearer triangle.
float search_radius(const TileSurfaces& surfaces, double distance_m) {
  return static_cast<float>(distance_m * (1 + kFartherSearch) + surfaces.tolerances().search_margin_m);
}

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
  args->query->radius = search_radius(surfaces, distance);
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
  const double margin = surfaces.tolerances().crowding_m;
  std::vector<std::uint8_t> crowded(surfaces.count(label));
  for (std::uint32_t k = 0; k < crowded.size(); ++k) {
    Neighbourhood own{&surfaces, label, surfaces.is_round(label), {}, surfaces.box_of({label, k}), false};
    if (!own.round) own.corners = surfaces.corners(label, k);
    const double radius = 0.5 * own.box.diagonal().norm();
    own.box.min().array() -= margin;
    own.box.max().array() += margin;
    query(tree, surfaces, own.box.center(), radius + margin, &visit_neighbour, &own);
    crowded[k] = own.crowded ? 1 : 0;
  }
  return crowded;
}

double nearest_triangle_m(RTCSceneTy* tree, const TileSurfaces& surfaces, bool meshes,
                          const Eigen::Vector3d& point_world_m, double nearest_m) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const Eigen::Vector3f p = (point_world_m - surfaces.middle_m()).cast<float>();
  RTCPointQuery query{p.x(), p.y(), p.z(), 0, search_radius(surfaces, nearest_m)};
  NearestTriangle nearest{&surfaces, meshes, point_world_m, nearest_m};
  rtcPointQuery(tree, &query, &context, &visit_triangle, &nearest);
  return nearest.distance_m;
}

}  // namespace uwsim
