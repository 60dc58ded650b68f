#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace uwsim {

/// A sphere, or a straight piece of a round pipe between two planes: what rays meet exactly, without facets.
struct RoundShape {
  /// Where a piece of pipe ends: the plane through `point_world_m` on its axis. A cap closes it.
  struct End {
    Eigen::Vector3d point_world_m;
    Eigen::Vector3d outward;  ///< unit, at less than 90 degrees to the axis that leaves through this end
    bool capped;
  };

  double radius_m;
  std::array<End, 2> ends;  ///< a sphere has its centre in both, and no direction
  Eigen::Vector3d axis;     ///< unit, from the first end to the second; zero for a sphere

  bool is_sphere() const { return axis.isZero(0); }
};

struct ShapeHit {
  double distance_m;
  Eigen::Vector3d normal_world;  ///< unit, outward
};

/// Box of all that lies on the shape, world axes.
struct ShapeBounds {
  Eigen::Vector3d low_m, high_m;
};

/// Throws InvalidValue unless everything is finite and the radius positive.
RoundShape sphere(const Eigen::Vector3d& centre_world_m, double radius_m);
/// With flat caps. Throws InvalidValue, also when the ends coincide.
RoundShape cylinder(const Eigen::Vector3d& start_world_m, const Eigen::Vector3d& end_world_m, double radius_m);
/// Along a line of two or more points, capped at both ends; pieces meet in the plane that halves the bend, as a welder
/// mitres them. Throws InvalidValue, also where a piece has no length or the line turns back on itself.
std::vector<RoundShape> pipe(const std::vector<Eigen::Vector3d>& line_world_m, double radius_m);

/// Where the ray first meets the shape's surface, from outside or inside, with near <= distance <= far. The direction
/// is a unit vector. Solved about the point of closest approach, so that it stays exact to some 1e-12 of the distances
/// involved (the plain quadratic loses digits far away).
std::optional<ShapeHit> first_hit(const RoundShape& shape, const Eigen::Vector3d& origin_world_m,
                                  const Eigen::Vector3d& direction_world, double near_m = 0,
                                  double far_m = std::numeric_limits<double>::infinity());

ShapeBounds bounds(const RoundShape& shape);

}  // namespace uwsim
