#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// OctoMap's two file formats as bytes, without OctoMap: a few header lines, then the tree in preorder.
///   .bt  maximum likelihood: two bytes an inner node, two bits a child: 0 unknown, 1 free, 2 occupied, 3 inner.
///   .ot  everything: a float32 of log-odds and a byte of child flags a node, leaves included.
/// OctoMap's own reader trusts what it reads: it recurses as deep as a file asks for, and prints instead of throwing.
/// So a file is proved here first.
namespace uwsim {

enum class MapFormat { bt, ot };

/// The tree has 16 levels below its root: a voxel's key is 16 bits an axis.
inline constexpr int kTreeDepth = 16;

struct OctreeFile {
  MapFormat format;
  double resolution_m;
  std::uint64_t nodes;                                      ///< 0 for an empty map, whose body is empty too
  std::size_t body_offset;                                  ///< where the tree begins
  std::array<std::uint64_t, kTreeDepth + 1> inner_nodes{};  ///< by depth
};

/// Reads the header and walks the whole tree. Throws InvalidValue that names `name` unless the id is OcTree, the
/// resolution is one of ours, no level lies below the 16th, no inner node is without children, every log-odds is
/// finite, the nodes are as many as the header says and the file ends where the tree does.
OctreeFile check_octree_file(std::string_view bytes, std::string_view name);

/// The header OctoMap writes. The resolution has six digits as there, and more where six would change it.
std::string octree_header(MapFormat format, std::uint64_t nodes, double resolution_m);

/// Throws InvalidValue unless the edge of a voxel is in [0.001, 1000] m.
void require_resolution(double resolution_m, std::string_view path);

}  // namespace uwsim
