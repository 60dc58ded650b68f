#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>

#include "uwsim/core/pose.h"
#include "uwsim/dynamics/collision_shape.h"

namespace uwsim {

/// A convex piece of a body, ready for distance queries: without margin, its faces known.
class ConvexShape {
 public:
  /// Keeps the corners that the piece's convex hull has.
  explicit ConvexShape(const ConvexPiece& points_body_m);
  ~ConvexShape();
  ConvexShape(ConvexShape&&) noexcept;
  ConvexShape& operator=(ConvexShape&&) noexcept;

  const ConvexPiece& corners_body_m() const { return corners_body_m_; }

 private:
  friend class ConvexMeeting;
  struct Impl;
  ConvexPiece corners_body_m_;
  std::unique_ptr<Impl> impl_;
};

/// A place where two shapes come near: on the second one, with the unit normal from there towards the first.
struct Meeting {
  Eigen::Vector3d point_world_m, normal_world;
  double distance_m;  ///< negative where they overlap
};

/// Where two convex shapes are nearest, and where faces meet, the corners of what they share (Bullet: GJK, EPA for what
/// overlaps, Sutherland and Hodgman's clipping). A pure function of the poses. Results last until the next call.
class ConvexMeeting {
 public:
  ConvexMeeting();
  ~ConvexMeeting();
  ConvexMeeting(ConvexMeeting&&) noexcept;
  ConvexMeeting& operator=(ConvexMeeting&&) noexcept;

  /// None when they are farther apart than `reach_m`. The triangle's corners are in the world.
  std::span<const Meeting> with_triangle(const ConvexShape& shape, const Pose& world_from_shape,
                                         const std::array<Eigen::Vector3d, 3>& corners_world_m, double reach_m);
  std::span<const Meeting> with_shape(const ConvexShape& shape, const Pose& world_from_shape, const ConvexShape& other,
                                      const Pose& world_from_other, double reach_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
