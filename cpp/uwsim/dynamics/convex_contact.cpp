#include "uwsim/dynamics/convex_contact.h"

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPolyhedron.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPolyhedralContactClipping.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "uwsim/dynamics/bullet_memory.h"

namespace uwsim {
namespace {

// Minimum cosine of the angle between a face's normal and the contact's normal for a face contact.
constexpr double kFlush = 0.98;
constexpr int kReservedCorners = 256;  // of a clipped face; a step that needs more allocates

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btTransform to_bullet(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), to_bullet(pose.position_m));
}

struct ContactPointList : btDiscreteCollisionDetectorInterface::Result {
  std::vector<ContactPoint> all;
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal, const btVector3& point, btScalar distance_m) override {
    all.push_back({from_bullet(point), from_bullet(normal).normalized(), distance_m});
  }
};

/// The largest cosine of the angle between a face's normal and `direction_world`.
double best_face_cosine(const btConvexPolyhedron& hull, const btTransform& transform,
                        const btVector3& direction_world) {
  // Multiplies the transpose of the rotation by the direction.
  const btVector3 direction = direction_world * transform.getBasis();
  double best = -1;
  for (int k = 0; k < hull.m_faces.size(); ++k) {
    const btScalar* plane = hull.m_faces[k].m_plane;
    best = std::max<double>(best, direction.dot(btVector3(plane[0], plane[1], plane[2])));
  }
  return best;
}

}  // namespace

struct ConvexShape::Impl {
  btConvexHullShape shape;
};

ConvexShape::ConvexShape(const ConvexPiece& points_body_m, const std::optional<RoundPiece>& round)
    : polytope_body_(points_body_m), round_body_(round), impl_(std::make_unique<Impl>()) {
  for (const Eigen::Vector3d& corner : polytope_body_.corners_m) impl_->shape.addPoint(to_bullet(corner), false);
  impl_->shape.setMargin(0);
  impl_->shape.recalcLocalAabb();
  impl_->shape.initializePolyhedralFeatures();
}
ConvexShape::~ConvexShape() = default;
ConvexShape::ConvexShape(ConvexShape&&) noexcept = default;
ConvexShape& ConvexShape::operator=(ConvexShape&&) noexcept = default;

struct ConvexContact::Impl {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btTriangleShape triangle{btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0)};
  btVertexArray clip_in, clip_out;
  ContactPointList points;

  Impl() {
    triangle.setMargin(0);
    clip_in.reserve(kReservedCorners);
    clip_out.reserve(kReservedCorners);
    points.all.reserve(kReservedCorners);
  }

  /// Fills `points` with the nearest point. Returns false if the shapes are farther apart than `reach_m`.
  bool find_nearest(const btConvexShape& a, const btTransform& world_from_a, const btConvexShape& b,
                    const btTransform& world_from_b, double reach_m) {
    points.all.clear();
    btGjkPairDetector detector(&a, &b, &simplex, &penetration);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = world_from_a;
    input.m_transformB = world_from_b;
    input.m_maximumDistanceSquared = reach_m * reach_m;
    detector.getClosestPoints(input, points, nullptr);
    std::erase_if(points.all,
                  [](const ContactPoint& p) { return !p.normal_world.allFinite() || !p.point_world_m.allFinite(); });
    return !points.all.empty();
  }
};

ConvexContact::ConvexContact() : impl_(std::make_unique<Impl>()) {}
ConvexContact::~ConvexContact() = default;
ConvexContact::ConvexContact(ConvexContact&&) noexcept = default;
ConvexContact& ConvexContact::operator=(ConvexContact&&) noexcept = default;

std::span<const ContactPoint> ConvexContact::with_triangle(const ConvexShape& shape, const Pose& world_from_shape,
                                                           const std::array<Eigen::Vector3d, 3>& corners_world_m,
                                                           double reach_m) {
  const auto& [a, b, c] = corners_world_m;
  impl_->triangle.m_vertices1[0] = to_bullet(a);
  impl_->triangle.m_vertices1[1] = to_bullet(b);
  impl_->triangle.m_vertices1[2] = to_bullet(c);
  impl_->find_nearest(shape.impl_->shape, to_bullet(world_from_shape), impl_->triangle, btTransform::getIdentity(),
                      reach_m);
  return impl_->points.all;
}

std::span<const ContactPoint> ConvexContact::with_shape(const ConvexShape& shape, const Pose& world_from_shape,
                                                        const ConvexShape& other, const Pose& world_from_other,
                                                        double reach_m) {
  const btTransform here = to_bullet(world_from_shape), there = to_bullet(world_from_other);
  std::vector<ContactPoint>& found = impl_->points.all;
  const std::optional<RoundPiece>&ball = shape.round_body(), &other_ball = other.round_body();
  if (ball && other_ball && ball->half_axis_m.isZero(0) && other_ball->half_axis_m.isZero(0)) {
    const Eigen::Vector3d centre = world_from_other.point(other_ball->middle_m);
    const Eigen::Vector3d apart = world_from_shape.point(ball->middle_m) - centre;
    const double gap_m = apart.norm() - ball->radius_m - other_ball->radius_m;
    const Eigen::Vector3d normal = apart.isZero(0) ? Eigen::Vector3d::UnitZ().eval() : apart.normalized();
    found.assign(gap_m <= reach_m ? 1 : 0, {centre + other_ball->radius_m * normal, normal, gap_m});
    return found;
  }
  if (!impl_->find_nearest(shape.impl_->shape, here, other.impl_->shape, there, reach_m)) return found;
  const btVector3 normal = to_bullet(found.front().normal_world);
  const btConvexPolyhedron &hull = *shape.impl_->shape.getConvexPolyhedron(),
                           &other_hull = *other.impl_->shape.getConvexPolyhedron();
  if (best_face_cosine(hull, here, -normal) > kFlush && best_face_cosine(other_hull, there, normal) > kFlush) {
    btPolyhedralContactClipping::clipHullAgainstHull(normal, hull, other_hull, here, there, -reach_m, reach_m,
                                                     impl_->clip_in, impl_->clip_out, impl_->points);
  }
  return found;
}

}  // namespace uwsim
