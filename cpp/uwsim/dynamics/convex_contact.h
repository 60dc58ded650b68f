#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "uwsim/core/pose.h"
#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/polytope.h"

namespace uwsim {

/// A convex piece of a body, prepared for distance queries, without Bullet's margin.
class ConvexShape {
 public:
  /// Keeps only the corners of the convex hull of the points.
  explicit ConvexShape(const ConvexPiece& points_body_m, const std::optional<RoundPiece>& round = {});
  ~ConvexShape();
  ConvexShape(ConvexShape&&) noexcept;
  ConvexShape& operator=(ConvexShape&&) noexcept;

  const Polytope& polytope_body() const { return polytope_body_; }
  /// The shape for which the polytope's facets stand.
  const std::optional<RoundPiece>& round_body() const { return round_body_; }

 private:
  friend class ConvexContact;
  struct Impl;
  Polytope polytope_body_;
  std::optional<RoundPiece> round_body_;
  std::unique_ptr<Impl> impl_;
};

/// A point of contact or near contact: it lies on the second shape, and its unit normal points to the first.
struct ContactPoint {
  Eigen::Vector3d point_world_m, normal_world;
  double distance_m;  ///< negative where they overlap
};

/// Finds the nearest points of two convex shapes and, where two faces meet, the corners of their common area. Uses
/// Bullet's GJK, EPA for overlaps, and clipping after Sutherland and Hodgman. The result is a pure function of the
/// poses and is valid until the next call.
class ConvexContact {
 public:
  ConvexContact();
  ~ConvexContact();
  ConvexContact(ConvexContact&&) noexcept;
  ConvexContact& operator=(ConvexContact&&) noexcept;

  /// The nearest points; empty if the shapes are farther apart than `reach_m`.
  std::span<const ContactPoint> with_triangle(const ConvexShape& shape, const Pose& world_from_shape,
                                              const std::array<Eigen::Vector3d, 3>& corners_world_m, double reach_m);
  /// The same; of two balls on the line of their centres, so that no facet turns them or adds energy.
  std::span<const ContactPoint> with_shape(const ConvexShape& shape, const Pose& world_from_shape,
                                           const ConvexShape& other, const Pose& world_from_other, double reach_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
