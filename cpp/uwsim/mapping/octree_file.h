#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "uwsim/mapping/voxel_key.h"

/// Checks OctoMap's two file formats without using OctoMap. Both have a few header lines, then the tree in preorder.
///   .bt  the most likely values: two bytes per inner node, two bits per child: 0 unknown, 1 free, 2 occupied, 3 inner.
///   .ot  all log-odds: a float32 of log-odds and a byte of child flags per node, including leaves.
/// OctoMap's own reader trusts the file: it recurses as deep as the file demands, and prints errors instead of
/// throwing. Every file is therefore checked here first.
namespace uwsim {

enum class MapFormat { bt, ot };

struct OctreeFile {
  MapFormat format;
  double resolution_m;
  std::uint64_t nodes;                                      ///< 0 for an empty map, whose body is also empty
  std::size_t body_offset;                                  ///< start of the tree in the file
  std::array<std::uint64_t, kTreeDepth + 1> inner_nodes{};  ///< by depth
};

/// Reads the header and walks the whole tree. Throws InvalidValue naming `name` unless the ID is OcTree, the resolution
/// passes require_resolution(), no node is below the 16th level, every inner node has children, all log-odds are
/// finite, the number of nodes matches the header, and the file ends where the tree does.
OctreeFile check_octree_file(std::string_view bytes, std::string_view name);

/// The header as OctoMap writes it. The resolution has six digits, as in OctoMap, or more if six would change its
/// value.
std::string octree_header(MapFormat format, std::uint64_t nodes, double resolution_m);

/// Throws InvalidValue unless the edge of a voxel is in [0.001, 1000] m.
void require_resolution(double resolution_m, std::string_view path);

}  // namespace uwsim
