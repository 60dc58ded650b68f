#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/world/heightfield.h"
#include "uwsim/world/round_shape.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// What a ray met or a vehicle touched: 0 nothing, 1 the terrain, 2.. the solids in the order they were added.
using Label = std::uint16_t;
inline constexpr Label kNothing = 0;
inline constexpr Label kTerrain = 1;

/// A fixed thing in the world: its mesh in world coordinates. Rays meet `shapes` where there are any, and the mesh
/// otherwise; contacts and the true surface are the mesh's, which follows the shapes as closely as its maker says.
struct Solid {
  std::string name;
  TriangleMesh mesh_world;
  std::vector<RoundShape> shapes;
  Eigen::Vector3d low_world_m, high_world_m;  ///< the box round it
};

/// The one world that feeds physics and rays: what the sonar sees is what the vehicle hits.
/// Copies are cheap; terrain and solids are shared and never change.
class World {
 public:
  Water water;

  void set_terrain(Heightfield terrain);
  /// Returns the solid's label. Names are unique. Throws InvalidValue.
  Label add_solid(std::string name, TriangleMesh mesh_world, std::vector<RoundShape> shapes = {});

  const std::shared_ptr<const Heightfield>& terrain() const { return terrain_; }
  const std::vector<std::shared_ptr<const Solid>>& solids() const { return solids_; }
  /// The first closed solid that the point is inside of, or null. Open meshes have no inside.
  const Solid* solid_around(const Eigen::Vector3d& point_world_m) const;
  /// Names by label: "nothing", "terrain", then the solids'.
  std::vector<std::string> label_names() const;

 private:
  std::shared_ptr<const Heightfield> terrain_;
  std::vector<std::shared_ptr<const Solid>> solids_;
};

}  // namespace uwsim
