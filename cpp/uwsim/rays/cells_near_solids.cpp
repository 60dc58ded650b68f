#include "uwsim/rays/cells_near_solids.h"

#include <algorithm>
#include <cmath>

#include "uwsim/rays/tile_surfaces.h"

namespace uwsim {
namespace {

using Found = std::vector<std::pair<std::uint32_t, TileMember>>;

/// Whether the box comes within the margin of the shape's sphere, or of the infinite cylinder that contains the shape.
bool may_touch(const RoundShape& shape, const Eigen::AlignedBox3d& box, double margin_m) {
  const Eigen::Vector3d from = box.center() - shape.ends[0].point_world_m;
  const double off_axis = (from - shape.axis.dot(from) * shape.axis).norm();
  return off_axis <= shape.radius_m + 0.5 * box.diagonal().norm() + margin_m;
}

void add_cells_near(const TileSurfaces& surfaces, const TileMember& member, Found& found) {
  const TileContents& block = surfaces.contents();
  const Heightfield& terrain = *surfaces.world().terrain();
  const bool round = surfaces.is_round(member.geometry);
  const double margin = surfaces.tolerances().near_terrain_m;
  Eigen::AlignedBox3d solid = surfaces.box_of(member);
  solid.min().array() -= margin;
  solid.max().array() += margin;
  const auto cell = [&](double at_m, double origin_m, std::uint32_t first, std::uint32_t count) {
    const double local = std::floor((at_m - origin_m) / terrain.spacing_m()) - first;
    return static_cast<std::int64_t>(std::clamp(local, -1.0, static_cast<double>(count)));
  };
  const auto column = [&](double x) { return cell(x, terrain.origin_m().x(), block.first_column, block.columns); };
  const auto row = [&](double y) { return cell(y, terrain.origin_m().y(), block.first_row, block.rows); };
  const std::int64_t last_row = std::min<std::int64_t>(row(solid.max().y()), block.rows - 1);
  const std::int64_t last_column = std::min<std::int64_t>(column(solid.max().x()), block.columns - 1);
  for (std::int64_t j = std::max<std::int64_t>(0, row(solid.min().y())); j <= last_row; ++j) {
    for (std::int64_t i = std::max<std::int64_t>(0, column(solid.min().x())); i <= last_column; ++i) {
      const auto at = static_cast<std::uint32_t>(j * block.columns + i);
      Eigen::AlignedBox3d ground = surfaces.box_of({TileSurfaces::kOpenTerrain, 2 * at});
      ground.extend(surfaces.box_of({TileSurfaces::kOpenTerrain, 2 * at + 1}));
      if (!solid.intersects(ground)) continue;
      if (round && !may_touch(surfaces.shape(member.geometry, member.primitive), ground, margin)) continue;
      found.push_back({at, member});
    }
  }
}

}  // namespace

CellsNearSolids::CellsNearSolids(std::size_t cells, std::span<const std::pair<std::uint32_t, TileMember>> found)
    : contains_(cells, 0) {
  for (const auto& [cell, member] : found) {
    if (contains_[cell] == 0) near_.push_back({cell, static_cast<std::uint32_t>(members_.size()), 0});
    contains_[cell] = 1;
    ++near_.back().count;
    members_.push_back(member);
  }
}

CellsNearSolids find_cells_near_solids(const TileSurfaces& surfaces) {
  const TileContents& block = surfaces.contents();
  Found found;
  if (block.columns == 0) return {0, found};
  for (const TileContents::Share& share : block.solids) {
    for (std::uint32_t k = 0; k < share.members.size(); ++k) add_cells_near(surfaces, {share.label, k}, found);
  }
  std::ranges::stable_sort(found, {}, [](const auto& entry) { return entry.first; });
  return {std::size_t{block.columns} * block.rows, found};
}

}  // namespace uwsim
