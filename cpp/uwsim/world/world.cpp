#include "uwsim/world/world.h"

#include <limits>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

void World::set_terrain(Heightfield terrain) { terrain_ = std::make_shared<const Heightfield>(std::move(terrain)); }

Label World::add_solid(std::string name, TriangleMesh mesh_world, std::vector<RoundShape> shapes) {
  require_well_formed(mesh_world, "solid '" + name + "'");
  require(!name.empty(), "solid.name", "''", "must not be empty");
  require(solids_.size() + kTerrain + 1 < std::numeric_limits<Label>::max(), "solids", solids_.size(), "too many");
  for (const std::string& known : label_names()) require(known != name, "solid.name", name, "must be unique");
  solids_.push_back(std::make_shared<const Solid>(Solid{std::move(name), std::move(mesh_world), std::move(shapes)}));
  return static_cast<Label>(kTerrain + solids_.size());
}

std::vector<std::string> World::label_names() const {
  std::vector<std::string> names = {"nothing", "terrain"};
  for (const auto& solid : solids_) names.push_back(solid->name);
  return names;
}

}  // namespace uwsim
