#pragma once

#include "uwsim/mapping/bricks/kernels/mark_buffer_avx512.h"
#include "uwsim/mapping/bricks/kernels/voxel_address_avx512.h"

/// Collects the marks of the slab walk and writes them to the table. Only the files named scan_kernels_*avx512.cpp may
/// include this file, after <immintrin.h>.
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

  /// Adds marks, after merging those of neighbouring rays that mark the same tile: a run of up to eight is merged into
  /// its first lane.
  void add(__m512i tile, __m512i mask) {
    merge<1>(tile, mask);
    merge<2>(tile, mask);
    merge<4>(tile, mask);
    const __m512i before = _mm512_alignr_epi32(tile, tile, 15);
    const __mmask16 first = static_cast<__mmask16>(_mm512_cmpneq_epi32_mask(tile, before) | 0x0101);
    const __mmask16 which = _mm512_mask_test_epi32_mask(first, mask, mask);
    _mm512_storeu_si512(tiles_ + count_, _mm512_maskz_compress_epi32(which, tile));
    _mm512_storeu_si512(masks_ + count_, _mm512_maskz_compress_epi32(which, mask));
    count_ += static_cast<std::size_t>(__builtin_popcount(which));
  }

  /// Writes all marks to the table, as half words in Morton order.
  void write(const SlabHeading& heading, MarkBuffer& buffer) {
    std::size_t halves = 0;
    for (std::size_t i = 0; i < count_; i += 16) {
      const __mmask16 lanes = static_cast<__mmask16>(count_ - i < 16 ? (1u << (count_ - i)) - 1 : 0xffff);
      const __m512i tile = _mm512_load_si512(tiles_ + i), mask = _mm512_load_si512(masks_ + i);
      halves = append_halves(heading, buffer, halves, lanes, tile, _mm512_and_si512(mask, _mm512_set1_epi32(0xffff)));
      halves = append_halves(heading, buffer, halves, lanes, add_one(tile, all_lanes(heading.tile_b)),
                             _mm512_srli_epi32(mask, 16));
    }
    buffer.write(halves);
    count_ = 0;
  }

 private:
  template <int kBy>
  static void merge(__m512i tile, __m512i& mask) {
    const __mmask16 same = _mm512_cmpeq_epi32_mask(tile, _mm512_alignr_epi32(tile, tile, kBy));
    mask = _mm512_mask_or_epi32(mask, same, mask, _mm512_alignr_epi32(mask, mask, kBy));
  }

  /// Reorders the bits b1 b0 a1 a0 of one tile to Morton order, y1 x1 0 y0 x0, and shifts them to the tile's lowest bit
  /// of z.
  static std::size_t append_halves(const SlabHeading& heading, MarkBuffer& buffer, std::size_t count, __mmask16 lanes,
                                   __m512i tile, __m512i mask) {
    mask = swapped<2>(mask, 0x0c0c);
    if (heading.a == 1) mask = swapped<4>(swapped<1>(mask, 0x2222), 0x00f0);
    mask = _mm512_and_si512(_mm512_or_si512(mask, _mm512_slli_epi32(mask, 8)), _mm512_set1_epi32(0x00ff00ff));
    mask = _mm512_and_si512(_mm512_or_si512(mask, _mm512_slli_epi32(mask, 4)), _mm512_set1_epi32(0x0f0f0f0f));
    mask = _mm512_sllv_epi32(mask, _mm512_and_si512(tile, _mm512_set1_epi32(4)));
    const __mmask16 which = _mm512_mask_test_epi32_mask(lanes, mask, mask);
    return buffer.append(count, which, _mm512_srli_epi32(tile, 5), mask);
  }

  /// Swaps the bits selected by `low` with the bits kBy positions higher.
  template <int kBy>
  static __m512i swapped(__m512i bits, int low) {
    const __m512i apart = _mm512_xor_si512(bits, _mm512_srli_epi32(bits, kBy));
    const __m512i change = _mm512_and_si512(apart, _mm512_set1_epi32(low));
    return _mm512_xor_si512(bits, _mm512_xor_si512(change, _mm512_slli_epi32(change, kBy)));
  }

  alignas(64) std::uint32_t tiles_[kCapacity + 64];
  alignas(64) std::uint32_t masks_[kCapacity + 64];
  std::size_t count_ = 0;
};

}  // namespace
}  // namespace uwsim::bricks
