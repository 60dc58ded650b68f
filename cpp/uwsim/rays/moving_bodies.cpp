#include "uwsim/rays/moving_bodies.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/rays/ray_bundle.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {
namespace {

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

/// Calls visit(body, label) for each body that the bundle may reach. The bundle is only made if a body is not hidden: a
/// lone vehicle, which does not perceive itself, pays nothing for it.
template <typename Bodies, typename MakeBundle, typename Visit>
void for_each_reached(const Bodies& bodies, Label first_label, std::size_t hidden, const MakeBundle& make_bundle,
                      Visit&& visit) {
  if (bodies.size() <= (hidden < bodies.size() ? 1u : 0u)) return;
  const RayBundle bundle = make_bundle();
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (k == hidden || !bundle.may_reach(bodies[k].centre_world_m, bodies[k].radius_m)) continue;
    visit(bodies[k], static_cast<Label>(first_label + k));
  }
}

}  // namespace

std::size_t MovingBodies::add(const TriangleMesh& surface_body_m) {
  require(first_label_ + bodies_.size() < std::numeric_limits<Label>::max(), "bodies", bodies_.size(), "too many");
  World alone;
  alone.add_solid("body", surface_body_m);
  const Solid& solid = *alone.solids().front();
  const Eigen::Vector3d centre_m = 0.5 * (solid.low_world_m + solid.high_world_m);
  const double radius_m = 0.5 * (solid.high_world_m - solid.low_world_m).norm() * (1 + kSphereMargin);
  bodies_.push_back({std::make_shared<const RayScene>(alone), centre_m, radius_m});
  place(bodies_.size() - 1, {});
  return bodies_.size() - 1;
}

void MovingBodies::place(std::size_t index, const Pose& world_from_body) {
  Body& body = bodies_.at(index);
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  body.position_world_m = world_from_body.position_m;
  body.body_from_world = rotation.transpose();
  body.centre_world_m = world_from_body.position_m + rotation * body.centre_body_m;
}

void MovingBodies::cast(std::span<const ExactRays> rays, std::size_t hidden, std::span<ExactHits> hits) const {
  for (std::size_t p = 0; p < rays.size(); ++p) {
    for_each_reached(
        bodies_, first_label_, hidden, [&] { return RayBundle(Eigen::Vector3d::Zero(), rays[p], hits[p].distance_m); },
        [&](const Body& body, Label label) { cast_at(body, label, rays[p], hits[p]); });
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
  for_each_reached(
      bodies_, first_label_, hidden, [&] { return RayBundle(anchor_world_m, rays, hits.distance_m); },
      [&](const Body& body, Label label) { cast_at(body, label, anchor_world_m, rays, order, hits); });
}

void MovingBodies::cast_at(const Body& body, Label label, const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                           RayOrder order, HitPacket& hits) {
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
    hits.piece[k] = 0;
  }
}

void MovingBodies::occlude(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, RayOrder order,
                           std::size_t hidden, Blocked& blocked) const {
  for_each_reached(
      bodies_, first_label_, hidden, [&] { return RayBundle(anchor_world_m, rays, rays.far_m); },
      [&](const Body& body, Label) {
        Blocked own;
        body.surface->occluded(body.body_from_world * (anchor_world_m - body.position_world_m),
                               turned(rays, body.body_from_world.cast<float>()), own, order);
        for (std::size_t k = 0; k < kPacketRays; ++k) blocked[k] |= own[k];
      });
}

bool MovingBodies::may_be_in(const RayCone& cone, std::size_t hidden) const {
  const RayBundle rays(cone);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (k != hidden && rays.may_reach(bodies_[k].centre_world_m, bodies_[k].radius_m)) return true;
  }
  return false;
}

double MovingBodies::distance(const Eigen::Vector3d& point_world_m, double nearest_m, std::size_t hidden) const {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body& body = bodies_[k];
    if (k == hidden || (body.centre_world_m - point_world_m).norm() - body.radius_m >= nearest_m) continue;
    const Eigen::Vector3d point_m = body.body_from_world * (point_world_m - body.position_world_m);
    double own_m = nearest_m;
    body.surface->distance({&point_m, 1}, {&own_m, 1});
    nearest_m = std::min(nearest_m, own_m);
  }
  return nearest_m;
}

}  // namespace uwsim
