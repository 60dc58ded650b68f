#include "uwsim/world/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kMostCoverPerM2 = 5000, kMostCover = 1e9;

/// Returns false if no triangle lies above a point, which is then not enclosed: the angles of all cost many times more.
bool may_be_enclosed(const TriangleMesh& mesh, const Eigen::Vector3d& point_m) {
  const auto& at = mesh.vertices_m;
  return std::ranges::any_of(mesh.triangles, [&](const Triangle& t) {
    const auto is_across = [&](int axis) {
      const auto [low, high] = std::minmax({at[t[0]][axis], at[t[1]][axis], at[t[2]][axis]});
      return low <= point_m[axis] && point_m[axis] <= high;
    };
    return is_across(0) && is_across(1) && std::max({at[t[0]].z(), at[t[1]].z(), at[t[2]].z()}) >= point_m.z();
  });
}

}  // namespace

void World::set_terrain(Heightfield terrain) { terrain_ = std::make_shared<const Heightfield>(std::move(terrain)); }

Label World::add_solid(std::string name, TriangleMesh mesh_world, std::vector<RoundShape> shapes) {
  require_well_formed(mesh_world, "solid '" + name + "'");
  require(!name.empty(), "solid.name", "''", "must not be empty");
  require(labels_end() < std::numeric_limits<Label>::max(), "solids", solids_.size(), "too many");
  require(cover_.empty(), "solid '" + name + "'", "after cover", "must be added before cover");
  for (const std::string& known : label_names()) require(known != name, "solid.name", name, "must be unique");
  Eigen::Vector3d low = mesh_world.vertices_m[mesh_world.triangles[0][0]], high = low;
  for (const Triangle& t : mesh_world.triangles) {
    for (const std::uint32_t v : t) {
      low = low.cwiseMin(mesh_world.vertices_m[v]);
      high = high.cwiseMax(mesh_world.vertices_m[v]);
    }
  }
  solids_.push_back(
      std::make_shared<const Solid>(Solid{std::move(name), std::move(mesh_world), std::move(shapes), low, high}));
  return static_cast<Label>(kTerrain + solids_.size());
}

void World::add_school(SchoolSpec school) { add_swarm(std::make_shared<const School>(std::move(school), terrain_)); }

void World::add_plume(PlumeSpec plume) { add_swarm(std::make_shared<const Plume>(std::move(plume))); }

void World::add_swarm(std::shared_ptr<const Swarm> swarm) {
  for (const auto& known : schools_)
    require(known->name() != swarm->name(), "life.name", swarm->name(), "must be unique");
  schools_.push_back(std::move(swarm));
}

Label World::add_cover(CoverLayer layer) {
  layer.check();
  require(terrain_ != nullptr, "cover '" + layer.name + "'", "no terrain", "must have terrain to lie on");
  require(labels_end() < std::numeric_limits<Label>::max(), "cover", cover_.size(), "too many layers");
  for (const std::string& known : label_names())
    require(known != layer.name, "cover.name", layer.name, "must be unique");
  double density_per_m2 = layer.density_per_m2;
  for (const auto& other : cover_) density_per_m2 += other->density_per_m2;
  require(density_per_m2 <= kMostCoverPerM2, "cover.density_per_m2", density_per_m2,
          "of all layers together must be at most 5000");
  const double pieces = density_per_m2 * (terrain_->far_corner_m() - terrain_->origin_m()).prod();
  require(pieces <= kMostCover, "cover.density_per_m2", density_per_m2,
          "makes " + std::to_string(pieces) + " pieces on this terrain, must be at most 1e9");
  cover_.push_back(std::make_shared<const CoverLayer>(std::move(layer)));
  return static_cast<Label>(labels_end() - 1);
}

const Solid* World::solid_around(const Eigen::Vector3d& point_world_m) const {
  // The winding number inside a closed mesh is 1 within rounding; it is less for an open mesh.
  constexpr double kEnclosed = 1 - 1e-6;
  for (const auto& solid : solids_) {
    const bool in_box = (point_world_m.array() >= solid->low_world_m.array()).all() &&
                        (point_world_m.array() <= solid->high_world_m.array()).all();
    if (in_box && may_be_enclosed(solid->mesh_world, point_world_m) &&
        std::abs(winding_number(solid->mesh_world, point_world_m)) > kEnclosed)
      return solid.get();
  }
  return nullptr;
}

std::vector<std::string> World::label_names() const {
  std::vector<std::string> names = {"nothing", "terrain"};
  for (const auto& solid : solids_) names.push_back(solid->name);
  for (const auto& layer : cover_) names.push_back(layer->name);
  return names;
}

}  // namespace uwsim
