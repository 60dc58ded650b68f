#pragma once

#include <utility>

#include "uwsim/core/built_when_used.h"
#include "uwsim/core/corner_normals.h"

namespace uwsim {

/// A solid's or a vehicle's mesh with the normals at its corners, which the first picture of it needs.
class SmoothMesh {
 public:
  explicit SmoothMesh(TriangleMesh mesh) : mesh_(std::move(mesh)) {}
  /// The smooth surface at a point of a triangle, in the mesh's frame. The normal is turned; zero where all is flat.
  SmoothPlace at(std::uint32_t triangle, const Eigen::Vector3d& point, const Eigen::Matrix3f& turn) const;

 private:
  TriangleMesh mesh_;
  BuiltWhenUsed<CornerNormals> normals_;
};

}  // namespace uwsim
