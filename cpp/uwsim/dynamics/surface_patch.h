#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace uwsim {

/// How the surface goes on beyond an edge of a triangle.
enum class Bend : std::uint8_t { kNone, kFlat, kConvex, kConcave };

/// A triangle of a fixed surface, world frame; `into` are unit vectors in its plane, perpendicular to its edges, of
/// which edge k goes from corner k to k + 1.
struct SurfaceTriangle {
  std::array<Eigen::Vector3d, 3> corners_m;
  std::array<Eigen::Vector3d, 3> into;
  Eigen::Vector3d normal, low_m, high_m;
  double offset_m;  ///< normal . r on the plane
  std::array<Bend, 3> bends{};

  explicit SurfaceTriangle(const std::array<Eigen::Vector3d, 3>& corners_m);
};

/// An edge between two triangles that the surface falls away from on both sides. `into` are unit vectors in their
/// planes, perpendicular to the edge.
struct SurfaceEdge {
  Eigen::Vector3d from_m, along, middle_normal;
  std::array<Eigen::Vector3d, 2> into;
  double length_m;

  /// The edge `k` of `triangle`, with the third corner of the triangle beyond.
  SurfaceEdge(const SurfaceTriangle& triangle, std::size_t k, const Eigen::Vector3d& beyond_m);
};

/// A point that the surface falls away from on all sides, with the ends of the edges that meet there.
struct SurfacePeak {
  Eigen::Vector3d point_m;
  std::uint32_t first_neighbour, neighbour_count;  ///< in SurfacePatch::neighbours_m
};

/// The part of a fixed surface near a body.
///
/// On its flat or hollow edges and points nothing can touch but what touches a triangle, too: they are not features. So
/// a body on a plane of many triangles meets one plane.
struct SurfacePatch {
  std::vector<SurfaceTriangle> triangles;
  std::vector<SurfaceEdge> edges;
  std::vector<SurfacePeak> peaks;
  std::vector<Eigen::Vector3d> neighbours_m;

  void reserve(std::size_t triangles_count);
  void clear();
};

/// Sine of the angle by which a flat surface may bend: 0.1 mm in a metre.
inline constexpr double kFlat = 1e-4;

}  // namespace uwsim
