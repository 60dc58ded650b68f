#pragma once

#include <cmath>
#include <numbers>

#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"

namespace uwsim::testing {

/// A closed box with the given edge lengths, centred on the origin.
inline TriangleMesh box(double x, double y, double z) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices_m.emplace_back((corner & 1 ? x : -x) / 2, (corner & 2 ? y : -y) / 2, (corner & 4 ? z : -z) / 2);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A closed sphere with `bands` latitude bands, centred on the origin.
inline TriangleMesh sphere(double radius, int bands) {
  TriangleMesh mesh;
  const int around = 2 * bands;
  mesh.vertices_m.emplace_back(0, 0, radius);
  for (int i = 1; i < bands; ++i) {
    const double polar = std::numbers::pi * i / bands;
    for (int j = 0; j < around; ++j) {
      const double angle = 2 * std::numbers::pi * j / around;
      mesh.vertices_m.emplace_back(radius * std::sin(polar) * std::cos(angle),
                                   radius * std::sin(polar) * std::sin(angle), radius * std::cos(polar));
    }
  }
  mesh.vertices_m.emplace_back(0, 0, -radius);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * around + j % around); };
  const auto last = static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
  for (int j = 0; j < around; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int i = 1; i < bands - 1; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.triangles.push_back({at(bands - 1, j), last, at(bands - 1, j + 1)});
  }
  return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex += by;
  return mesh;
}

inline TriangleMesh placed(TriangleMesh mesh, const Pose& pose) {
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex = pose.point(vertex);
  return mesh;
}

inline TriangleMesh stretched(TriangleMesh mesh, const Eigen::Vector3d& factors) {
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex = vertex.cwiseProduct(factors);
  return mesh;
}

}  // namespace uwsim::testing
