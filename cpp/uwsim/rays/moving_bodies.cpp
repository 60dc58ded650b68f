#include "uwsim/rays/moving_bodies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/built_when_used.h"
#include "uwsim/core/check.h"
#include "uwsim/core/recently_made.h"
#include "uwsim/rays/ray_bundle.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

constexpr std::size_t kGroup = 8;       // neighbouring fish that are excluded together
constexpr double kSphereMargin = 1e-5;  // margin for float rays, as a fraction of the radius

/// Rotates a packet from world axes to body axes, in float.
RayPacket turned(const RayPacket& rays, const Eigen::Matrix3f& rotation) {
  RayPacket out = rays;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3f origin = rotation * Eigen::Vector3f(rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]);
    const Eigen::Vector3f direction =
        rotation * Eigen::Vector3f(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
    out.origin_x[k] = origin.x(), out.origin_y[k] = origin.y(), out.origin_z[k] = origin.z();
    out.direction_x[k] = direction.x(), out.direction_y[k] = direction.y(), out.direction_z[k] = direction.z();
  }
  return out;
}

auto reached_by(const RayBundle& bundle) {
  return [&bundle](const Eigen::Vector3d& centre_m, double radius_m) { return bundle.may_reach(centre_m, radius_m); };
}

/// Returns true if any ray of a packet may reach a sphere; conservative. Written without branches, for vector units.
template <typename Packet, typename Distances>
bool any_reaches(const Eigen::Vector3d& anchor_world_m, const Packet& rays, const Distances& distance_m,
                 const Eigen::Vector3d& centre_world_m, double radius_m) {
  using Real = typename Distances::value_type;
  constexpr Real kRounding = 2e-6f;  // of the square of a distance in float
  const Eigen::Matrix<Real, 3, 1> centre = (centre_world_m - anchor_world_m).template cast<Real>();
  const Real radius = static_cast<Real>(radius_m), square = radius * radius;
  std::int32_t any = 0;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Real x = centre.x() - rays.origin_x[k], y = centre.y() - rays.origin_y[k], z = centre.z() - rays.origin_z[k];
    const Real along = x * rays.direction_x[k] + y * rays.direction_y[k] + z * rays.direction_z[k];
    const Real far2 = x * x + y * y + z * z, reach = std::min(rays.far_m[k], distance_m[k]);
    const bool hits =
        (far2 - along * along <= square + kRounding * far2) & (along >= -radius) & (along - radius <= reach);
    any |= hits ? rays.active[k] : 0;
  }
  return any != 0;
}

constexpr auto every = [](const Eigen::Vector3d&, double) { return true; };

}  // namespace

struct MovingBodies::PlacedSchool {
  std::shared_ptr<const SwimmingSchool> school;
  double time_s;
  BuiltWhenUsed<Shoal> shoal = {};

  const Shoal& reached() const {
    return shoal.get([&] { return school->at(time_s); });
  }
};

MovingBodies::Body MovingBodies::prepared(const TriangleMesh& surface_body_m) {
  World alone;
  alone.add_solid("body", surface_body_m);
  const Solid& solid = *alone.solids().front();
  const Eigen::Vector3d centre_m = 0.5 * (solid.low_world_m + solid.high_world_m);
  const double radius_m = 0.5 * (solid.high_world_m - solid.low_world_m).norm() * (1 + kSphereMargin);
  return {std::make_shared<const RayScene>(alone), centre_m, radius_m};
}

std::size_t MovingBodies::add(const TriangleMesh& surface_body_m) {
  require(first_label_ + bodies_.size() + schools_.size() < std::numeric_limits<Label>::max(), "bodies", bodies_.size(),
          "too many");
  bodies_.push_back(prepared(surface_body_m));
  place(bodies_.size() - 1, {});
  return bodies_.size() - 1;
}

MovingBodies::SwimmingSchool::SwimmingSchool(std::shared_ptr<const Swarm> swims)
    : school(std::move(swims)), radius_m(0) {
  for (const std::vector<TriangleMesh>& phases : school->shapes_m()) {
    std::vector<Body>& bodies = shapes.emplace_back();
    for (const TriangleMesh& mesh : phases) {
      bodies.push_back(prepared(mesh));
      radius_m = std::max(radius_m, bodies.back().centre_body_m.norm() + bodies.back().radius_m);
    }
  }
  radius_m *= 1 + kSphereMargin;
  reach_m = (school->reach_m() + radius_m) * (1 + kSphereMargin);
}

/// All of a world's simulations and cameras share the fishes' trees.
MovingBodies::MovingBodies(Label first_label, std::span<const std::shared_ptr<const Swarm>> schools)
    : first_label_(first_label) {
  static auto& made = *new RecentlyMade<SwimmingSchool>;  // never destroyed, like the scenes in RayScene
  for (const auto& school : schools) {
    schools_.push_back(made.find_or_make(
        false, [&](const SwimmingSchool& known) { return known.school == school; },
        [&] { return std::make_shared<const SwimmingSchool>(school); }));
  }
  place_schools(0);
}

void MovingBodies::place_schools(double time_s) {
  placed_.clear();
  for (const auto& school : schools_) {
    auto placed = std::make_shared<PlacedSchool>();
    placed->school = school;
    placed->time_s = time_s;
    placed_.push_back(std::move(placed));
  }
}

MovingBodies::Shoal MovingBodies::SwimmingSchool::at(double time_s) const {
  Shoal shoal;
  shoal.fish.resize(school->size());
  school->place(time_s, shoal.fish);
  shoal.groups.reserve(shoal.fish.size() / kGroup + 1);
  for (std::size_t first = 0; first < shoal.fish.size(); first += kGroup) {
    const std::size_t end = std::min(first + kGroup, shoal.fish.size());
    Eigen::Vector3d low = shoal.fish[first].position_world_m, high = low;
    for (std::size_t k = first + 1; k < end; ++k) {
      low = low.cwiseMin(shoal.fish[k].position_world_m);
      high = high.cwiseMax(shoal.fish[k].position_world_m);
    }
    const double reach_m = 0.5 * (high - low).norm() + radius_m;
    shoal.groups.push_back({0.5 * (low + high), reach_m * (1 + kSphereMargin)});
  }
  return shoal;
}

MovingBodies::Body MovingBodies::SwimmingSchool::placed(const Swimmer& fish) const {
  Body body = shapes[fish.size][fish.phase];
  const Eigen::Matrix3d rotation = fish.rotation();
  body.position_world_m = fish.position_world_m;
  body.body_from_world = rotation.transpose();
  body.centre_world_m = fish.position_world_m + rotation * body.centre_body_m;
  return body;
}

/// Calls visit(body, label, piece) for each body and each fish whose sphere may_reach(centre, radius) does not exclude;
/// fish also by may_hit, which is dearer.
template <typename Reaches, typename Hits, typename Visit>
void MovingBodies::for_each_reached(std::size_t hidden, const Reaches& may_reach, const Hits& may_hit,
                                    Visit&& visit) const {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (k == hidden || !may_reach(bodies_[k].centre_world_m, bodies_[k].radius_m)) continue;
    visit(bodies_[k], label(k), std::uint32_t{0});
  }
  for (std::size_t k = 0; k < placed_.size(); ++k) {
    const SwimmingSchool& school = *placed_[k]->school;
    if (!may_reach(school.school->middle_world_m(), school.reach_m)) continue;
    const Shoal& shoal = placed_[k]->reached();
    for (std::size_t g = 0; g < shoal.groups.size(); ++g) {
      if (!may_reach(shoal.groups[g].centre_world_m, shoal.groups[g].radius_m)) continue;
      for (std::size_t fish = g * kGroup; fish < std::min((g + 1) * kGroup, shoal.fish.size()); ++fish) {
        const Eigen::Vector3d& at = shoal.fish[fish].position_world_m;
        if (!may_reach(at, school.radius_m) || !may_hit(at, school.radius_m)) continue;
        visit(school.placed(shoal.fish[fish]), school_label(k), static_cast<std::uint32_t>(fish + 1));
      }
    }
  }
}

void MovingBodies::place(std::size_t index, const Pose& world_from_body) {
  Body& body = bodies_.at(index);
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  body.position_world_m = world_from_body.position_m;
  body.body_from_world = rotation.transpose();
  body.centre_world_m = world_from_body.position_m + rotation * body.centre_body_m;
}

void MovingBodies::cast(std::span<const ExactRays> rays, std::size_t hidden, std::span<ExactHits> hits) const {
  if (!has_targets(hidden)) return;
  for (std::size_t p = 0; p < rays.size(); ++p) {
    const RayBundle bundle(Eigen::Vector3d::Zero(), rays[p], hits[p].distance_m);
    for_each_reached(
        hidden, reached_by(bundle),
        [&](const Eigen::Vector3d& centre_m, double radius_m) {
          return any_reaches(Eigen::Vector3d::Zero(), rays[p], hits[p].distance_m, centre_m, radius_m);
        },
        [&](const Body& body, Label label, std::uint32_t) { cast_at(body, label, rays[p], hits[p]); });
  }
}

/// Rays start where they reach the sphere around the body, because float requires them to be close to its tile.
void MovingBodies::cast_at(const Body& body, Label label, const ExactRays& rays, ExactHits& hits) {
  ExactRays local;
  ExactRays::Lanes start_m;
  bool any = false;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const Eigen::Vector3d origin = origin_of(rays, k), direction = direction_of(rays, k);
    const Eigen::Vector3d to_centre = body.centre_world_m - origin;
    const double along_m = to_centre.dot(direction), reach_m = std::min(rays.far_m[k], hits.distance_m[k]);
    start_m[k] = std::max(0.0, along_m - body.radius_m);
    const bool reaches = rays.active[k] != 0 && along_m >= -body.radius_m && start_m[k] <= reach_m &&
                         (to_centre - along_m * direction).squaredNorm() <= body.radius_m * body.radius_m;
    any |= reaches;
    if (reaches) {
      set_ray(local, k, body.body_from_world * (origin - body.position_world_m + start_m[k] * direction),
              body.body_from_world * direction, reach_m - start_m[k], true);
    } else {
      set_ray(local, k, body.centre_body_m, Eigen::Vector3d::UnitX(), 0, false);
    }
  }
  if (!any) return;
  ExactHits met;
  body.surface->cast({&local, 1}, {&met, 1});
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double distance_m = start_m[k] + met.distance_m[k];
    if (local.active[k] == 0 || !(distance_m < hits.distance_m[k])) continue;
    set_hit(hits, k, distance_m, body.body_from_world.transpose() * normal_of(met, k), label);
  }
}

void MovingBodies::cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order,
                        std::size_t hidden, HitPacket& hits) const {
  if (!has_targets(hidden)) return;
  const RayBundle bundle(anchor_world_m, rays, hits.distance_m);
  for_each_reached(
      hidden, reached_by(bundle),
      [&](const Eigen::Vector3d& centre_m, double radius_m) {
        return any_reaches(anchor_world_m, rays, hits.distance_m, centre_m, radius_m);
      },
      [&](const Body& body, Label label, std::uint32_t piece) {
        cast_at(body, label, anchor_world_m, rays, order, piece, hits);
      });
}

void MovingBodies::cast_at(const Body& body, Label label, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                           RayOrder order, std::uint32_t piece, HitPacket& hits) {
  const Eigen::Matrix3f rotation = body.body_from_world.cast<float>();
  HitPacket met;
  body.surface->cast(body.body_from_world * (anchor_world_m - body.position_world_m), turned(rays, rotation), met,
                     order);
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    if (rays.active[k] == 0 || !(met.distance_m[k] < hits.distance_m[k])) continue;
    const Eigen::Vector3f normal =
        rotation.transpose() * Eigen::Vector3f(met.normal_x[k], met.normal_y[k], met.normal_z[k]);
    hits.distance_m[k] = met.distance_m[k];
    hits.u[k] = met.u[k], hits.v[k] = met.v[k];
    hits.normal_x[k] = normal.x(), hits.normal_y[k] = normal.y(), hits.normal_z[k] = normal.z();
    hits.label[k] = label;
    hits.primitive[k] = met.primitive[k];
    hits.settled[k] = met.settled[k];
    hits.piece[k] = piece;
  }
}

/// Null for fish.
const MovingBodies::Body* MovingBodies::body_of(Label body_label) const {
  std::size_t body = body_label - first_label_;
  if (body >= before_schools_) body -= std::min(body, schools_.size());
  return body < bodies_.size() ? &bodies_[body] : nullptr;
}

Eigen::Matrix3f MovingBodies::turn_of(Label body_label) const {
  const Body* const body = body_of(body_label);
  if (body == nullptr) return Eigen::Matrix3f::Identity();
  return body->body_from_world.transpose().cast<float>();
}

Eigen::Vector3d MovingBodies::on_body(Label body_label, const Eigen::Vector3d& point_world_m) const {
  const Body* const body = body_of(body_label);
  if (body == nullptr) return point_world_m;
  return body->body_from_world * (point_world_m - body->position_world_m);
}

void MovingBodies::occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order,
                           std::size_t hidden, Blocked& blocked) const {
  if (!has_targets(hidden)) return;
  const RayBundle bundle(anchor_world_m, rays, rays.far_m);
  for_each_reached(
      hidden, reached_by(bundle),
      [&](const Eigen::Vector3d& centre_m, double radius_m) {
        return any_reaches(anchor_world_m, rays, rays.far_m, centre_m, radius_m);
      },
      [&](const Body& body, Label, std::uint32_t) {
        Blocked own;
        body.surface->occluded(body.body_from_world * (anchor_world_m - body.position_world_m),
                               turned(rays, body.body_from_world.cast<float>()), own, order);
        for (std::size_t k = 0; k < kPacketRays; ++k) blocked[k] |= own[k];
      });
}

bool MovingBodies::may_be_in(const RayCone& cone, std::size_t hidden) const {
  if (!has_targets(hidden)) return false;
  const RayBundle bundle(cone);
  bool any = false;
  for_each_reached(
      hidden,
      [&](const Eigen::Vector3d& centre_m, double radius_m) { return !any && bundle.may_reach(centre_m, radius_m); },
      every, [&](const Body&, Label, std::uint32_t) { any = true; });
  return any;
}

double MovingBodies::distance(const Eigen::Vector3d& point_world_m, double nearest_m, std::size_t hidden) const {
  for_each_reached(
      hidden,
      [&](const Eigen::Vector3d& centre_m, double radius_m) {
        return (centre_m - point_world_m).norm() - radius_m < nearest_m;
      },
      every,
      [&](const Body& body, Label, std::uint32_t) {
        const Eigen::Vector3d point_m = body.body_from_world * (point_world_m - body.position_world_m);
        double own_m = nearest_m;
        body.surface->distance({&point_m, 1}, {&own_m, 1});
        nearest_m = std::min(nearest_m, own_m);
      });
  return nearest_m;
}

}  // namespace uwsim
