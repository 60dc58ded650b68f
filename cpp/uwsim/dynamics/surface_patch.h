#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace uwsim {

/// How the surface continues beyond an edge of a triangle.
enum class Bend : std::uint8_t { kNone, kFlat, kConvex, kConcave };

/// A triangle of a fixed surface, world frame. Edge k runs from corner k to corner k + 1; `into` are unit vectors in
/// the triangle's plane, perpendicular to the edges.
struct SurfaceTriangle {
  std::array<Eigen::Vector3d, 3> corners_m;
  std::array<Eigen::Vector3d, 3> into;
  Eigen::Vector3d normal, low_m, high_m;
  double offset_m;  ///< normal . r for points of the plane
  std::array<Bend, 3> bends{};

  explicit SurfaceTriangle(const std::array<Eigen::Vector3d, 3>& corners_m);
};

/// An edge between two triangles where the surface falls away on both sides. `into` are unit vectors in their planes,
/// perpendicular to the edge.
struct SurfaceEdge {
  Eigen::Vector3d from_m, along, middle_normal;
  std::array<Eigen::Vector3d, 2> into;
  double length_m;

  /// Edge `k` of `triangle`, with the third corner of the triangle beyond it.
  SurfaceEdge(const SurfaceTriangle& triangle, std::size_t k, const Eigen::Vector3d& beyond_m);
};

/// A point from which the surface falls away on all sides. The neighbours are the far ends of the edges that meet
/// there.
struct SurfacePeak {
  Eigen::Vector3d point_m;
  std::uint32_t first_neighbour, neighbour_count;  ///< in SurfacePatch::neighbours_m
};

/// The part of a fixed surface near a body.
///
/// Flat and concave edges and points are not features: anything that touches one also touches a triangle. A body on a
/// plane of many triangles thus touches a single plane.
struct SurfacePatch {
  std::vector<SurfaceTriangle> triangles;
  std::vector<SurfaceEdge> edges;
  std::vector<SurfacePeak> peaks;
  std::vector<Eigen::Vector3d> neighbours_m;

  void reserve(std::size_t triangles_count);
  void clear();
};

/// Sine of the largest angle by which a surface may bend at an edge and still count as flat: 0.1 mm per metre.
inline constexpr double kFlat = 1e-4;

}  // namespace uwsim
