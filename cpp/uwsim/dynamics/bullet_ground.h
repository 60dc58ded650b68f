#pragma once

#include <memory>
#include <vector>

#include "uwsim/world/world.h"

class btCollisionShape;

namespace uwsim {

/// Terrain, solids and solid pieces of cover as fixed shapes for Bullet's dynamics; immutable, and shared by all worlds
/// with the same surfaces.
class BulletGround {
 public:
  struct Part {
    btCollisionShape* shape;
    Eigen::Vector3d position_world_m;  ///< of its origin
  };

  explicit BulletGround(const World& source);
  ~BulletGround();
  static std::shared_ptr<const BulletGround> of(const World& world);

  /// The terrain, all solids as one part, and the cover, as far as there are any.
  const std::vector<Part>& parts() const { return parts_; }

 private:
  struct Shapes;
  World world_;  // without water; owns the arrays that the shapes refer to
  std::unique_ptr<Shapes> shapes_;
  std::vector<Part> parts_;
};

}  // namespace uwsim
