#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/core/instruction_set.h"
#include "uwsim/mapping/bricks/brick.h"
#include "uwsim/mapping/log_odds.h"

/// The inner loops of the brick engine, in three versions with the same results: portable, AVX2 and AVX-512
/// (scan_kernels_*.cpp). This header contains only plain structs and raw pointers, because files that are compiled for
/// newer processors must not emit code that the linker could use in other files
/// (tests/cpp/mapping/scan_kernels_stay_apart.sh checks this).
///
/// A scan is processed by the members of Kernels in order; bricks/README.md shows the whole process.
namespace uwsim {
namespace bricks {

struct ScanInput {
  const float* points_world_m;  ///< rows of x, y, z
  std::size_t count;            ///< number of points
  double tree_origin_world_m[3];
  float origin_m[3];   ///< start of all rays, in the tree's frame
  double max_range_m;  ///< negative: no limit
  double resolution_m;
};

enum RayKind : std::uint8_t {
  kSkipped = 0,    ///< the point is not finite
  kHit = 1,        ///< the ray ends in the voxel of its point, which is hit
  kTruncated = 2,  ///< the point is beyond max_range_m: the ray ends at that range, without a hit
};

/// One ray per point of a scan, in columns. If a ray does not move along an axis, next and stride are the largest
/// double.
struct Rays {
  double* next[3];            ///< distance along the ray to the first face across this axis [m]
  double* stride[3];          ///< distance between two successive crossings [m]
  double* length;             ///< [m]
  std::uint16_t* end_key[3];  ///< key of the voxel where the ray ends; the origin's for skipped rays
  std::uint32_t* steps;       ///< number of faces between the first voxel and the last; 0 if the ray stays in one voxel
  std::uint8_t* negative;     ///< bit `axis` is set if the ray runs in the negative direction of that axis
  std::uint8_t* kind;         ///< RayKind
};

/// Rays walk from voxel to voxel by address (address_layout.h): the bits of axis_mask[axis] are the coordinate along
/// that axis. The addresses of rays that run in the negative direction of an axis are mirrored along it (all its bits
/// flipped), so that every step adds one.
struct WalkInput {
  const Rays* rays;
  /// Indices of the rays to walk, sorted by number of steps; padded to a multiple of 32 by repeating the last index
  const std::uint32_t* order;
  std::size_t count;                 ///< number of rays, excluding the padding
  const std::uint64_t* end_address;  ///< end of each ray, mirrored
  std::uint64_t origin_address;      ///< not mirrored
  std::uint64_t axis_mask[3];
  /// Marks of the traversed voxels: one bit per voxel, and one byte per brick that contains any.
  std::uint64_t* table;
  std::uint8_t* touched;
  /// Called instead if `table` is null, with the bits of one word of 64 voxels.
  void (*mark)(void* context, std::uint64_t word, std::uint64_t mask);
  void* context;
};

/// The effect of one scan on one brick: which of the brick's eight words contain missed and hit voxels. The masks of
/// these words, with one bit per voxel, are stored consecutively in a separate list: first those of the missed words,
/// then those of the hit words.
struct TraceEntry {
  std::uint16_t brick;  ///< within its chunk, in Morton order
  std::uint8_t missed_words;
  std::uint8_t hit_words;
};

/// The part of the tables that belongs to one chunk: 512 bricks of 8 words. Collecting also zeroes this part.
struct CollectInput {
  std::uint64_t* missed;  ///< voxels that rays passed through
  std::uint64_t* hit;     ///< voxels that hold points
  std::uint8_t* touched;  ///< one byte per brick: 1 missed, 2 hit
  TraceEntry* entries;    ///< room for 512
  std::uint64_t* masks;   ///< room for 8,192, plus 8 that may be overwritten
};
struct Collected {
  std::size_t entries;
  std::size_t masks;
};

struct UpdateInput {
  OccupancyLogOdds model;
  Brick* const* bricks;  ///< one brick per entry; null if the entry changes nothing
  const TraceEntry* entries;
  std::size_t count;
  const std::uint64_t* masks;
  std::uint8_t* freed_block;  ///< one byte per entry; set to 1 if the brick returned a block
  BlockPool* blocks;          ///< a pool with at least 8 free blocks per entry
};

struct Kernels {
  void (*start_rays)(const ScanInput& scan, const Rays& rays);  ///< converts points to rays
  void (*walk)(const WalkInput& walk);                          ///< converts rays to marked voxels
  Collected (*collect)(const CollectInput& chunk);              ///< converts marked voxels to entries and masks
  void (*update)(const UpdateInput& update);                    ///< converts entries and masks to log-odds
};

extern const Kernels kPortableKernels, kAvx2Kernels, kAvx512Kernels;

}  // namespace bricks

/// Throws InvalidValue if this processor does not support the set.
const bricks::Kernels& kernels_for(InstructionSet set);

}  // namespace uwsim
