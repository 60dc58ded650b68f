#pragma once

#include "uwsim/mapping/bricks/kernels/mark_buffer.h"
#include "uwsim/mapping/bricks/kernels/voxel_address.h"

/// Collects the marks of the slab walk and writes them to the table. Compiled into each scan_kernels_slabs_*.cpp.
namespace uwsim::bricks {
namespace {

/// The main axis a of a group of rays, and their direction along it. A tile is 4 x 4 voxels at one level in z, aligned
/// to its size.
struct SlabHeading {
  std::uint32_t mask_a, mask_b, mask_z;  ///< bits of an address that hold the coordinate along the axis
  std::uint32_t tile_a, tile_b;          ///< mask_a and mask_b without the two lowest bits of each coordinate
  std::uint32_t origin;                  ///< address of the origin
  int a, b;                              ///< 0 for x, 1 for y
  bool down;                             ///< the rays run in the negative direction of the main axis
  int passed_slabs;                      ///< number of slabs in the origin's tile before the origin
  int at_a, at_b;                        ///< position of the origin within its tile

  SlabHeading(const WalkInput& in, unsigned heading) {
    a = heading > 2 ? 1 : 0;
    b = 1 - a;
    down = heading == 2 || heading == 4;
    mask_a = static_cast<std::uint32_t>(in.axis_mask[a]);
    mask_b = static_cast<std::uint32_t>(in.axis_mask[b]);
    mask_z = static_cast<std::uint32_t>(in.axis_mask[2]);
    tile_a = mask_a & ~(9u << a);
    tile_b = mask_b & ~(9u << b);
    origin = static_cast<std::uint32_t>(in.origin_address);
    const auto within = [&](int axis) { return static_cast<int>((origin >> axis & 1) | (origin >> (axis + 2) & 2)); };
    at_a = within(a);
    at_b = within(b);
    passed_slabs = down ? 3 - at_a : at_a;
  }
};

/// A buffer of marked tiles, which are written only when it is certain which voxels their rays cross. Each has the
/// address of a tile, and a mask with bits numbered b2 b1 b0 a1 a0 for the voxels of this tile and of the next tile
/// along b.
class TileMarks {
 public:
  static constexpr std::size_t kCapacity = 1024;

  std::size_t count() const { return count_; }
  void clear() { count_ = 0; }

  /// Adds marks, after merging those of neighbouring rays that mark the same tile: a run of up to kRun is merged into
  /// its first lane.
  void add(Lanes tile, Lanes mask) {
    merge<1>(tile, mask);
    merge<2>(tile, mask);
    if constexpr (kRun > 4) merge<4>(tile, mask);
    const LaneMask merged = without(is_equal(tile, previous_lanes(tile)), starts_of_runs());
    const LaneMask which = without(has_any(mask, mask), merged);
    store(tiles_ + count_, compressed(which, tile));
    store(masks_ + count_, compressed(which, mask));
    count_ += bricks::count(which);
  }

  /// Writes all marks to the table, as half words in Morton order.
  void write(const SlabHeading& heading, MarkBuffer& buffer) {
    std::size_t halves = 0;
    for (std::size_t i = 0; i < count_; i += kLanes) {
      const LaneMask lanes = first_lanes(count_ - i);
      const Lanes tile = load(tiles_ + i), mask = load(masks_ + i);
      halves = append_halves(heading, buffer, halves, lanes, tile, mask & all_lanes(0xffff));
      halves =
          append_halves(heading, buffer, halves, lanes, add_one(tile, all_lanes(heading.tile_b)), shift_down<16>(mask));
    }
    buffer.write(halves);
    count_ = 0;
  }

 private:
  template <int kBy>
  static void merge(Lanes tile, Lanes& mask) {
    mask = join(is_equal(tile, next_lanes<kBy>(tile)), mask, next_lanes<kBy>(mask));
  }

  /// Reorders the bits b1 b0 a1 a0 of one tile to Morton order, y1 x1 0 y0 x0, and shifts them to the tile's lowest bit
  /// of z.
  static std::size_t append_halves(const SlabHeading& heading, MarkBuffer& buffer, std::size_t marks, LaneMask lanes,
                                   Lanes tile, Lanes mask) {
    mask = swapped<2>(mask, 0x0c0c);
    if (heading.a == 1) mask = swapped<4>(swapped<1>(mask, 0x2222), 0x00f0);
    mask = (mask | shift_up<8>(mask)) & all_lanes(0x00ff00ff);
    mask = (mask | shift_up<4>(mask)) & all_lanes(0x0f0f0f0f);
    mask = shift_each_up(mask, tile & all_lanes(4));
    return buffer.append(marks, lanes & has_any(mask, mask), shift_down<5>(tile), mask);
  }

  /// Swaps the bits selected by `low` with the bits kBy positions higher.
  template <int kBy>
  static Lanes swapped(Lanes bits, std::uint32_t low) {
    const Lanes change = (bits ^ shift_down<kBy>(bits)) & all_lanes(low);
    return bits ^ change ^ shift_up<kBy>(change);
  }

  alignas(64) std::uint32_t tiles_[kCapacity + 64];
  alignas(64) std::uint32_t masks_[kCapacity + 64];
  std::size_t count_ = 0;
};

}  // namespace
}  // namespace uwsim::bricks
