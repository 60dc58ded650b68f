#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/surface_patch.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A spatial index of the triangles of a world's solids (Bullet's bounding-volume trees). Several threads may search
/// it, each with its own Stack.
class SolidTriangles {
 public:
  /// The working memory of a search, kept so that a step does not allocate.
  class Stack {
   public:
    Stack();
    ~Stack();
    Stack(Stack&&) noexcept;
    Stack& operator=(Stack&&) noexcept;

   private:
    friend class SolidTriangles;
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  explicit SolidTriangles(const World& world);
  ~SolidTriangles();
  SolidTriangles(SolidTriangles&&) noexcept;
  SolidTriangles& operator=(SolidTriangles&&) noexcept;

  /// Writes one patch for each solid with triangles whose bounding boxes overlap the given box, in a fixed order, and
  /// returns the number of patches. `patches` only grows, so its memory is reused. Throws ContactBudgetExceeded.
  std::size_t find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m, Stack& stack,
                   std::vector<SurfacePatch>& patches, ContactBudget& budget) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
