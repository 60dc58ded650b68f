#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "uwsim/core/triangle_mesh.h"
#include "uwsim/world/cover.h"
#include "uwsim/world/heightfield.h"
#include "uwsim/world/plume.h"
#include "uwsim/world/round_shape.h"
#include "uwsim/world/school.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// Identifies surfaces: 0 for nothing, 1 for the terrain, 2 and up for the solids in the order in which they were
/// added, then the layers of cover.
using Label = std::uint16_t;
inline constexpr Label kNothing = 0;
inline constexpr Label kTerrain = 1;

/// A fixed solid. Rays hit its `shapes` if it has any, and its mesh otherwise. Contacts and the reference surface for
/// scoring use the mesh, which approximates the shapes as accurately as its creator chose.
struct Solid {
  std::string name;
  TriangleMesh mesh_world;
  std::vector<RoundShape> shapes;
  Eigen::Vector3d low_world_m, high_world_m;  ///< corners of its bounding box
};

/// The world that dynamics and rays share, so that the sonar sees the same surfaces that the vehicle hits. Copies are
/// cheap: they share terrain, solids, cover and schools, which are immutable.
class World {
 public:
  Water water;

  void set_terrain(Heightfield terrain);
  /// Returns the solid's label. Names are unique. Throws InvalidValue.
  Label add_solid(std::string name, TriangleMesh mesh_world, std::vector<RoundShape> shapes = {});
  /// Adds a layer of pieces on the terrain and returns its label; no solid may be added after it. Throws InvalidValue.
  Label add_cover(CoverLayer layer);
  /// Adds a school of fish, which only instruments meet. Its label follows those of all bodies: MovingBodies. Throws
  /// InvalidValue.
  void add_school(SchoolSpec school);
  /// Adds a plume of bubbles in the same way.
  void add_plume(PlumeSpec plume);

  const std::shared_ptr<const Heightfield>& terrain() const { return terrain_; }
  const std::vector<std::shared_ptr<const Solid>>& solids() const { return solids_; }
  const std::vector<std::shared_ptr<const CoverLayer>>& cover() const { return cover_; }
  const std::vector<std::shared_ptr<const Swarm>>& schools() const { return schools_; }
  Label first_cover() const { return static_cast<Label>(kTerrain + 1 + solids_.size()); }
  /// The first label that no surface of the world has.
  Label labels_end() const { return static_cast<Label>(first_cover() + cover_.size()); }
  /// The first closed solid that encloses the point, or null. An open mesh encloses nothing.
  const Solid* solid_around(const Eigen::Vector3d& point_world_m) const;
  /// Names by label: "nothing", "terrain", then the names of the solids and of the layers of cover.
  std::vector<std::string> label_names() const;

 private:
  void add_swarm(std::shared_ptr<const Swarm> swarm);

  std::shared_ptr<const Heightfield> terrain_;
  std::vector<std::shared_ptr<const Solid>> solids_;
  std::vector<std::shared_ptr<const CoverLayer>> cover_;
  std::vector<std::shared_ptr<const Swarm>> schools_;  // and plumes
};

}  // namespace uwsim
