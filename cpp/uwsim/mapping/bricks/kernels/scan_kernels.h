#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/bricks/brick.h"
#include "uwsim/mapping/log_odds.h"

/// The inner loops of the brick engine, in three forms with the same results: portable, AVX2 and AVX-512
/// (scan_kernels_*.cpp). Plain structs and raw pointers only: files that are compiled for newer processors must not
/// emit code that other files could link (tests/cpp/scan_kernels_stay_apart.sh checks this).
///
/// A scan goes through them in the order of Kernels' members; bricks/README.md shows the whole path.
namespace uwsim {
namespace bricks {

struct ScanInput {
  const float* points_world_m;  ///< x, y, z by rows
  std::size_t count;            ///< points
  double tree_origin_world_m[3];
  float origin_m[3];   ///< where the rays start, in the tree's frame
  double max_range_m;  ///< negative: no limit
  double resolution_m;
};

enum RayKind : std::uint8_t {
  kSkipped = 0,    ///< the point is non-finite
  kHit = 1,        ///< the ray ends in its point's voxel, which is hit
  kTruncated = 2,  ///< the point lies beyond max_range_m: the ray ends there and hits nothing
};

/// One ray for each point of a scan, by columns. Where a ray does not move along an axis, next and stride are the
/// greatest double.
struct Rays {
  double* next[3];            ///< distance along the ray to the first face that it crosses across this axis [m]
  double* stride[3];          ///< distance between two such crossings [m]
  double* length;             ///< [m]
  std::uint16_t* end_key[3];  ///< key of the voxel where the ray ends; the origin's for skipped rays
  std::uint32_t* steps;       ///< faces between the first voxel and the last; 0: the ray stays in one voxel
  std::uint8_t* negative;     ///< bit `axis` is set if the ray runs down that axis
  std::uint8_t* kind;         ///< RayKind
};

/// Rays walk from voxel to voxel by their addresses (address_layout.h): the bits of axis_mask[axis] are the
/// coordinate along that axis. The addresses of rays that run down an axis are mirrored along it (all its bits
/// flipped), so that every step adds one.
struct WalkInput {
  const Rays* rays;
  const std::uint32_t* order;        ///< rays to walk, by their steps; padded to a multiple of 32 by repeating the last
  std::size_t count;                 ///< without the padding
  const std::uint64_t* end_address;  ///< of each ray, mirrored
  std::uint64_t origin_address;      ///< not mirrored
  std::uint64_t axis_mask[3];
  /// Where passed voxels are marked: one bit a voxel, and one byte a brick that has any.
  std::uint64_t* table;
  std::uint8_t* touched;
  /// Called instead if `table` is null, with the bits of one word of 64 voxels.
  void (*mark)(void* context, std::uint64_t word, std::uint64_t mask);
  void* context;
};

/// Numbers of the rays that can be walked slab by slab, by columns; slab_setup_avx512.h explains them. Main axis a: the
/// one of x and y that the ray runs along most; middle axis b: the other; minor axis: z.
struct SlabRays {
  std::uint8_t* heading;                              ///< 0: not walked by slabs; 1 to 4: a is +x, -x, +y, -y
  std::uint32_t *slabs, *flags;                       ///< faces across a that the ray crosses; SlabFlag
  std::uint32_t *slope, *fraction;                    ///< faces across b: crossed in each slab, crossed so far
  std::uint32_t *minor_slab, *minor_fraction;         ///< slab in which the ray crosses the next face across z
  std::uint32_t *minor_slabs, *minor_slabs_fraction;  ///< slabs from that crossing to the one after it
  std::uint32_t *minor_middle, *minor_middles;  ///< position along b at that crossing, modulo 2; change to the next
};
struct SlabInput {
  const Rays* rays;
  std::size_t count;
  std::uint32_t origin_key[3];
  const SlabRays* slab_rays;   ///< written by `setup`, read by `walk`
  const std::uint32_t* order;  ///< rays to walk, by heading
  std::size_t first[5];        ///< rays of heading h are order[first[h - 1]] to order[first[h] - 1]
};
struct SlabKernels {
  void (*setup)(const SlabInput& slabs);                        ///< finds the rays that can be walked by slabs
  void (*walk)(const SlabInput& slabs, const WalkInput& walk);  ///< marks their voxels in the table
};

/// The effect of one scan on one brick: which of its eight words have voxels to miss and to hit. Their masks, one bit a
/// voxel, follow one another in a list beside the entries: first those of the missed words, then those of the hit ones.
struct TraceEntry {
  std::uint16_t brick;  ///< within its chunk, in Morton order
  std::uint8_t missed_words;
  std::uint8_t hit_words;
};

/// One chunk's part of the tables: 512 bricks of 8 words. It is zeroed on the way.
struct CollectInput {
  std::uint64_t* missed;  ///< voxels that rays passed
  std::uint64_t* hit;     ///< voxels that hold points
  std::uint8_t* touched;  ///< one byte a brick: 1 missed, 2 hit
  TraceEntry* entries;    ///< space for 512
  std::uint64_t* masks;   ///< space for 8,192, and 8 more that may be overwritten
};
struct Collected {
  std::size_t entries;
  std::size_t masks;
};

struct UpdateInput {
  OccupancyLogOdds model;
  Brick* const* bricks;  ///< one an entry; null: the entry changes nothing
  const TraceEntry* entries;
  std::size_t count;
  const std::uint64_t* masks;
  std::uint8_t* freed_block;  ///< one an entry: set to 1 if the brick gave back a block
  BlockPool* blocks;          ///< with at least 8 free ones an entry
};

struct Kernels {
  void (*start_rays)(const ScanInput& scan, const Rays& rays);  ///< points to rays
  void (*walk)(const WalkInput& walk);                          ///< rays to marked voxels
  Collected (*collect)(const CollectInput& chunk);              ///< marked voxels to entries and masks
  void (*update)(const UpdateInput& update);                    ///< entries and masks to log-odds
  const SlabKernels* slabs;                                     ///< a faster walk for most rays; null: none
};

extern const SlabKernels kAvx512SlabKernels;
extern const Kernels kPortableKernels, kAvx2Kernels, kAvx512Kernels;

}  // namespace bricks

/// Throws InvalidValue if this processor does not have the set.
const bricks::Kernels& kernels_for(InstructionSet set);

}  // namespace uwsim
