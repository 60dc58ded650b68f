#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace uwsim {

class TileSurfaces;

/// A triangle or round shape of a solid, identified by the tile's surface numbers.
struct TileMember {
  std::uint32_t geometry, primitive;
};

/// The terrain cells of a tile that are close to solids, each with the nearby triangles and shapes of those solids. In
/// these cells, a cast in float cannot tell whether the terrain or the solid is hit first.
class CellsNearSolids {
 public:
  CellsNearSolids() = default;
  /// `found`: pairs of a cell and a nearby triangle or shape, sorted by cell, for a block of `cells` cells.
  CellsNearSolids(std::size_t cells, std::span<const std::pair<std::uint32_t, TileMember>> found);

  std::size_t size() const { return near_.size(); }
  /// Whether a cell of the block is in the list.
  bool contains(std::uint32_t cell) const { return contains_[cell] != 0; }
  /// The number, within the block, of the k-th cell in the list.
  std::uint32_t cell(std::uint32_t k) const { return near_[k].cell; }
  /// The solids near the k-th cell in the list.
  std::span<const TileMember> solids(std::uint32_t k) const {
    return std::span(members_).subspan(near_[k].first, near_[k].count);
  }

 private:
  struct Cell {
    std::uint32_t cell, first, count;  // within the block; within `members_`
  };
  std::vector<std::uint8_t> contains_;  // by cell of the block
  std::vector<Cell> near_;
  std::vector<TileMember> members_;
};

/// Compares every triangle and shape of a tile with the terrain cells around it.
CellsNearSolids find_cells_near_solids(const TileSurfaces& surfaces);

}  // namespace uwsim
