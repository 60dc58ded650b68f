#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "uwsim/dynamics/internal_edges.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A spatial index of the triangles of a world's solids (Bullet's bounding-volume trees).
class SolidTriangles {
 public:
  struct Index {
    std::size_t solid, triangle;
  };

  explicit SolidTriangles(const World& world);
  ~SolidTriangles();
  SolidTriangles(SolidTriangles&&) noexcept;
  SolidTriangles& operator=(SolidTriangles&&) noexcept;

  /// Replaces `found` by the triangles whose bounding boxes overlap the box, in a fixed order.
  void find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m, std::vector<Index>& found);
  std::array<Eigen::Vector3d, 3> corners_world_m(const Index& index) const;
  const InternalEdges& edges(const Index& index) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
