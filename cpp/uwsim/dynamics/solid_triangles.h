#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "uwsim/dynamics/surface_patch.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A spatial index of the triangles of a world's solids (Bullet's bounding-volume trees).
class SolidTriangles {
 public:
  explicit SolidTriangles(const World& world);
  ~SolidTriangles();
  SolidTriangles(SolidTriangles&&) noexcept;
  SolidTriangles& operator=(SolidTriangles&&) noexcept;

  /// Writes one patch for each solid that has triangles whose bounding boxes overlap the box, in a fixed order, and
  /// returns how many these are. `patches` only grows, so that its memory is used again.
  std::size_t find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                   std::vector<SurfacePatch>& patches);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
