#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace uwsim {

// Overlap of adjoining pieces, so that no ray slips between them.
inline constexpr double kSeam_m = 1e-9;
// Squared sine of the angle to the axis; a ray at a smaller angle counts as parallel to the wall
inline constexpr double kAlongAxis = 1e-24;

/// A sphere, or a straight piece of a round pipe between two planes. Ray hits are exact, without facets.
struct RoundShape {
  /// The plane that bounds one end of a piece of pipe.
  struct End {
    Eigen::Vector3d point_world_m;  ///< on the axis
    Eigen::Vector3d outward;        ///< unit normal pointing out of the piece, at less than 90 degrees to the axis
    bool capped;                    ///< whether it is closed by a flat cap
  };

  double radius_m;
  std::array<End, 2> ends;  ///< for a sphere, its centre twice, with `outward` zero
  Eigen::Vector3d axis;     ///< unit, from the first end to the second; zero for a sphere

  bool is_sphere() const { return axis.isZero(0); }
  /// True for a piece from the middle of a pipe, whose wall is its only surface.
  bool is_open() const { return !is_sphere() && !ends[0].capped && !ends[1].capped; }
};

struct ShapeHit {
  double distance_m;
  Eigen::Vector3d normal_world;  ///< unit, outward
};

/// An axis-aligned bounding box, world frame.
struct ShapeBounds {
  Eigen::Vector3d low_m, high_m;
};

/// Throws InvalidValue unless the centre is finite and the radius finite and positive.
RoundShape sphere(const Eigen::Vector3d& centre_world_m, double radius_m);
/// A cylinder with flat caps. Throws InvalidValue for the same reasons, and if the ends coincide.
RoundShape cylinder(const Eigen::Vector3d& start_world_m, const Eigen::Vector3d& end_world_m, double radius_m);
/// A pipe along a line of two or more points, capped at both ends. Adjacent pieces join in the plane that bisects the
/// bend (a mitre joint). Throws InvalidValue for the same reasons, and if a piece has no length or the line turns back
/// on itself.
std::vector<RoundShape> pipe(const std::vector<Eigen::Vector3d>& line_world_m, double radius_m);

/// The first point where the ray hits the shape's surface, from outside or inside, with near <= distance <= far. The
/// direction is a unit vector. Solved relative to the point of closest approach, which keeps the result exact to about
/// 1e-12 of the distances involved (the textbook quadratic formula loses digits far away).
std::optional<ShapeHit> first_hit(const RoundShape& shape, const Eigen::Vector3d& origin_world_m,
                                  const Eigen::Vector3d& direction_world, double near_m = 0,
                                  double far_m = std::numeric_limits<double>::infinity());

/// The radius of the largest ball about the point that fits inside the shape: the distance to the nearest of the
/// shape's wall and ends. Negative outside.
double depth_within(const RoundShape& shape, const Eigen::Vector3d& point_world_m);

ShapeBounds bounds(const RoundShape& shape);

}  // namespace uwsim
