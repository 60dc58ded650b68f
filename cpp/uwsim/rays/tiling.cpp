#include "uwsim/rays/tiling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "uwsim/rays/tolerances.h"

namespace uwsim {
namespace {

constexpr double kFineTileWidth_m = 50;
constexpr double kFineEdge = 8;  // as a multiple of the widening

using Key = std::pair<std::int64_t, std::int64_t>;  // a tile's row and column

/// Defines where the world is divided: between blocks of terrain cells or, if there is no terrain, every kTileWidth_m.
struct Cuts {
  Eigen::Vector2d origin_m, width_m;
  std::uint32_t columns = 0, rows = 0;  // per tile, in terrain cells

  Key tile_at(const Eigen::Vector3d& point) const {
    const auto part = [](double from_origin_m, double width) {
      return static_cast<std::int64_t>(std::clamp(std::floor(from_origin_m / width), -1e15, 1e15));
    };
    return {part(point.y() - origin_m.y(), width_m.y()), part(point.x() - origin_m.x(), width_m.x())};
  }
};

/// The largest number of cells that fits in a tile, with cells distributed evenly over the tiles.
std::uint32_t cells_a_tile(std::size_t cells, double spacing_m) {
  const double most = std::max(1.0, std::floor(kTileWidth_m / spacing_m)), count = static_cast<double>(cells);
  return static_cast<std::uint32_t>(std::ceil(count / std::ceil(count / most)));
}

Cuts cuts_of(const World& world, const Eigen::AlignedBox2d& extent) {
  const Eigen::Vector2d size = extent.sizes();
  const bool one = size.maxCoeff() <= kTileWidth_m;
  if (!world.terrain()) return {extent.min(), Eigen::Vector2d::Constant(one ? 2 * kTileWidth_m : kTileWidth_m)};
  const Heightfield& terrain = *world.terrain();
  const auto columns = static_cast<std::uint32_t>(terrain.nx() - 1),
             rows = static_cast<std::uint32_t>(terrain.ny() - 1);
  if (one) return {extent.min(), Eigen::Vector2d::Constant(2 * kTileWidth_m), columns, rows};
  const std::uint32_t nx = cells_a_tile(columns, terrain.spacing_m()), ny = cells_a_tile(rows, terrain.spacing_m());
  return {terrain.origin_m(), terrain.spacing_m() * Eigen::Vector2d(nx, ny), nx, ny};
}

Eigen::AlignedBox2d extent_of(const World& world) {
  Eigen::AlignedBox2d extent;
  if (world.terrain()) extent.extend(world.terrain()->origin_m()).extend(world.terrain()->far_corner_m());
  for (const auto& solid : world.solids()) {
    for (const Eigen::Vector3d& v : solid->mesh_world.vertices_m) extent.extend(v.head<2>().eval());
  }
  return extent;
}

void add_terrain(const Heightfield& terrain, const Cuts& cuts, std::map<Key, TileContents>& tiles) {
  const auto columns = static_cast<std::uint32_t>(terrain.nx() - 1),
             rows = static_cast<std::uint32_t>(terrain.ny() - 1);
  for (std::uint32_t j = 0; j < rows; j += cuts.rows) {
    for (std::uint32_t i = 0; i < columns; i += cuts.columns) {
      TileContents& tile = tiles[{j / cuts.rows, i / cuts.columns}];
      tile.first_row = j;
      tile.first_column = i;
      tile.rows = std::min(cuts.rows, rows - j);
      tile.columns = std::min(cuts.columns, columns - i);
    }
  }
}

using Shares = std::vector<TileContents::Share> TileContents::*;

void add_member(std::map<Key, TileContents>& tiles, const Key& key, Shares shares, Label label, std::uint32_t member) {
  auto& list = tiles[key].*shares;
  if (list.empty() || list.back().label != label) list.push_back({label, {}});
  list.back().members.push_back(member);
}

void add_solid(const Solid& solid, Label label, const Cuts& cuts, std::map<Key, TileContents>& tiles) {
  for (std::uint32_t k = 0; k < solid.shapes.size(); ++k) {
    const ShapeBounds box = bounds(solid.shapes[k]);
    add_member(tiles, cuts.tile_at(0.5 * (box.low_m + box.high_m)), &TileContents::solids, label, k);
  }
  const Shares shares = solid.shapes.empty() ? &TileContents::solids : &TileContents::meshes;
  for (std::uint32_t k = 0; k < solid.mesh_world.triangles.size(); ++k) {
    const Triangle& t = solid.mesh_world.triangles[k];
    const auto& v = solid.mesh_world.vertices_m;
    add_member(tiles, cuts.tile_at((v[t[0]] + v[t[1]] + v[t[2]]) / 3), shares, label, k);
  }
}

/// Whether a solid's triangles are so small that the margins that float requires in one of the world's tiles
/// (tolerances.h) would overlap them. Most hits on them would then require a search.
bool is_fine(const Solid& solid, const Eigen::AlignedBox2d& world) {
  if (!solid.shapes.empty()) return false;
  const double widening_m = tolerances_of(world.sizes().cwiseMin(kTileWidth_m).norm(), 1, true).widening_m;
  double sum_m = 0;
  const auto& v = solid.mesh_world.vertices_m;
  for (const Triangle& t : solid.mesh_world.triangles)
    sum_m += (v[t[1]] - v[t[0]]).norm() + (v[t[2]] - v[t[1]]).norm() + (v[t[0]] - v[t[2]]).norm();
  return sum_m < kFineEdge * widening_m * 3 * static_cast<double>(solid.mesh_world.triangles.size());
}

}  // namespace

std::vector<TileContents> cut_into_tiles(const World& world) {
  if (!world.terrain() && world.solids().empty()) return {};
  const Eigen::AlignedBox2d extent = extent_of(world);
  const Cuts cuts = cuts_of(world, extent);
  std::map<Key, TileContents> tiles;
  std::vector<TileContents> list;
  const auto take = [&list](std::map<Key, TileContents>& cut) {
    for (auto& [key, tile] : cut) list.push_back(std::move(tile));
  };
  if (world.terrain()) add_terrain(*world.terrain(), cuts, tiles);
  for (std::size_t k = 0; k < world.solids().size(); ++k) {
    const Solid& solid = *world.solids()[k];
    const auto label = static_cast<Label>(kTerrain + 1 + k);
    if (!is_fine(solid, extent)) {
      add_solid(solid, label, cuts, tiles);
      continue;
    }
    std::map<Key, TileContents> own;
    add_solid(solid, label, {solid.low_world_m.head<2>(), Eigen::Vector2d::Constant(kFineTileWidth_m)}, own);
    take(own);
  }
  take(tiles);
  return list;
}

}  // namespace uwsim
