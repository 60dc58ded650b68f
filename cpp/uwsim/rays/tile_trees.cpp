#include "uwsim/rays/tile_trees.h"

#include <utility>

#include "uwsim/rays/embree_query.h"
#include "uwsim/rays/embree_terrain.h"

namespace uwsim {

TileTrees::TileTrees(RTCDeviceTy* device, const World& world, TileContents contents)
    : surfaces(world, std::move(contents)), tree(make_ray_tree(device, true)), mesh_tree(make_ray_tree(device, false)) {
  const auto geometries = static_cast<std::uint32_t>(world.solids().size() + kTerrain + 1);
  round.reserve(geometries), widened.reserve(geometries);
  std::size_t triangles = 0;
  for (std::uint32_t geometry = 0; geometry < geometries; ++geometry) {
    if (surfaces.count(geometry) == 0) continue;
    triangles += surfaces.count(geometry);
    if (surfaces.is_round(geometry)) {
      round.push_back(round_geometry(surfaces, geometry));
      attach_round(device, tree.get(), round.back());
    } else if (TileSurfaces::is_terrain(geometry)) {
      attach_terrain(device, tree.get(), surfaces, geometry);
    } else {
      attach_triangles(device, tree.get(), geometry, widened.emplace_back(surfaces));
    }
  }
  for (std::size_t k = 0; k < surfaces.contents().meshes.size(); ++k) attach_mesh(device, mesh_tree.get(), surfaces, k);
  commit(device, tree.get(), triangles);
  commit(device, mesh_tree.get(), triangles);
  if (surfaces.count(TileSurfaces::kOpenTerrain) > 0) block = surfaces.terrain_block();
  crowded.resize(geometries);
  for (const TileContents::Share& share : surfaces.contents().solids) {
    crowded[share.label] = crowded_members(tree.get(), surfaces, share.label);
  }
}

}  // namespace uwsim
