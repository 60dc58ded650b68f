#include "uwsim/dynamics/contact_shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/recently_made.h"
#include "uwsim/world/same_surfaces.h"

namespace uwsim {
namespace {

ConvexBody made_body(std::span<const ConvexPiece> pieces_body_m, const std::optional<RoundPiece>& round) {
  ConvexBody body;
  body.round = round;
  body.points_m.assign(pieces_body_m.begin(), pieces_body_m.end());
  ConvexPiece all;
  for (const ConvexPiece& points : pieces_body_m) {
    ConvexShape shape(points, round);
    const ConvexPiece& corners = shape.polytope_body().corners_m;
    const BodyBox box = round ? BodyBox{round->middle_m, round->half_size_m()} : BodyBox::around(corners);
    all.insert(all.end(), corners.begin(), corners.end());
    body.pieces.push_back({std::move(shape), box});
  }
  if (all.empty()) return body;
  body.box = round ? body.pieces.front().box : BodyBox::around(all);
  for (const Eigen::Vector3d& corner : all) body.radius_m = std::max(body.radius_m, corner.norm());
  if (round) {
    const double out_m = round->half_axis_m.norm();
    const double reach_m = round->has_flat_ends ? std::hypot(out_m, round->radius_m) : out_m + round->radius_m;
    body.radius_m = std::max(body.radius_m, round->middle_m.norm() + reach_m);
  }
  return body;
}

}  // namespace

BodyBox BodyBox::around(const ConvexPiece& points_m) {
  Eigen::Vector3d low = points_m.front(), high = low;
  for (const Eigen::Vector3d& p : points_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {0.5 * (low + high), 0.5 * (high - low)};
}

WorldBox BodyBox::in_world(const Eigen::Vector3d& position_m, const Eigen::Matrix3d& rotation, double reach_m) const {
  const Eigen::Vector3d middle = position_m + rotation * middle_body_m;
  const Eigen::Vector3d half = rotation.cwiseAbs() * half_size_body_m + Eigen::Vector3d::Constant(reach_m);
  return {middle - half, middle + half};
}

std::shared_ptr<const ConvexBody> convex_body(std::span<const ConvexPiece> pieces_body_m,
                                              const std::optional<RoundPiece>& round) {
  static RecentlyMade<ConvexBody> known;
  return known.find_or_make(
      false,
      [&](const ConvexBody& other) {
        return other.round == round && std::ranges::equal(other.points_m, pieces_body_m);
      },
      [&] { return std::make_shared<const ConvexBody>(made_body(pieces_body_m, round)); });
}

FixedSurfaces::FixedSurfaces(const World& source) : world(source), broad_phase(source), solids(source) {
  world.water = {};
  const bool is_solid = CoverTriangles::lie_in(world), has_plants = Canopy::grows_in(world);
  if (is_solid || has_plants) plan.emplace(world);
  if (is_solid) cover.emplace(world, *plan);
  if (has_plants) canopy.emplace(world, *plan, broad_phase);
}

bool FixedSurfaces::may_touch(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const {
  if (!cover) return broad_phase.may_touch(low_world_m, high_world_m);
  const Eigen::Vector3d beyond = Eigen::Vector3d::Constant(cover->reach_m());
  return broad_phase.may_touch(low_world_m - beyond, high_world_m + beyond);
}

std::size_t FixedSurfaces::find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                                SolidTriangles::Stack& stack, std::vector<SurfacePatch>& patches,
                                ContactBudget& budget) const {
  const std::size_t count = solids.find(low_world_m, high_world_m, stack, patches, budget);
  return cover ? cover->find(low_world_m, high_world_m, count, patches, budget) : count;
}

std::shared_ptr<const FixedSurfaces> fixed_surfaces(const World& world) {
  static RecentlyMade<FixedSurfaces> known;
  return known.find_or_make(
      false, [&](const FixedSurfaces& other) { return have_same_surfaces(other.world, world); },
      [&] { return std::make_shared<const FixedSurfaces>(world); });
}

}  // namespace uwsim
