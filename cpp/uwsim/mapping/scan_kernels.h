#pragma once

#include <cstddef>
#include <cstdint>

/// The inner loops of the brick engine, in three forms of the same results: portable, AVX2 and AVX-512. Plain structs
/// and raw pointers only: the files that are compiled for newer processors must not emit code that others might link.
namespace uwsim {

/// Which form to run. `best` is the widest that the processor knows.
enum class InstructionSet { best, portable, avx2, avx512 };

namespace bricks {

inline constexpr std::uint32_t kNone = 0xffffffff;

/// Log-odds of the sensor model and of its limits.
struct SensorModel {
  float hit;
  float miss;
  float lowest;
  float highest;
};

/// 8 x 8 x 8 voxels in Morton order: word w holds the 4 x 4 x 4 voxels w, which share one block of 64 log-odds. A word
/// needs no block while all that is known in it is at `SensorModel::lowest` exactly: most of the water of a survey.
struct alignas(64) Brick {
  std::uint64_t known[8];
  std::uint64_t low[8];  ///< known, and at or below the lowest log-odds: a miss changes nothing
  std::uint32_t block[8];
};

/// Blocks of 64 log-odds: a stack of free ones, in segments of 2^kSegmentBits.
inline constexpr int kSegmentBits = 13;
struct Blocks {
  float* const* segments;
  std::uint32_t* free;
  std::uint32_t free_count;

  float* at(std::uint32_t block) const {
    return segments[block >> kSegmentBits] + 64 * std::size_t{block & ((1u << kSegmentBits) - 1)};
  }
};

/// What one scan does to one brick: the words with bits to free, the words with bits to fill. Their masks follow one
/// another in a list of their own.
struct Entry {
  std::uint16_t brick;  ///< within its chunk, Morton order
  std::uint8_t free_words;
  std::uint8_t hit_words;
};

struct ScanInput {
  const float* points_world_m;  ///< x, y, z by rows
  std::size_t count;
  double tree_origin_world_m[3];
  float origin_m[3];   ///< of the rays, in the tree's frame
  double max_range_m;  ///< negative: no limit
  double resolution_m;
};

enum Kind : std::uint8_t { kSkipped = 0, kHit = 1, kPassing = 2 };

/// Rays by columns.
struct Rays {
  double* next[3];            ///< where along the ray it next crosses a face across this axis [m]
  double* stride[3];          ///< between two such crossings [m]
  double* length;             ///< [m]
  std::uint16_t* end_key[3];  ///< voxel of the end
  std::uint32_t* steps;       ///< from the first voxel to the last, along faces; 0: they are one
  std::uint8_t* negative;     ///< a bit an axis
  std::uint8_t* kind;
};

/// A voxel's address is its key with the bits of each axis spread out to where `axis_mask` has ones. Rays that run down
/// an axis are mirrored there, so that every step adds one.
struct WalkInput {
  const Rays* rays;
  const std::uint32_t* order;        ///< rays to walk, by their steps; padded to a multiple of 32 by repeating the last
  std::size_t count;                 ///< without the padding
  const std::uint64_t* end_address;  ///< of each ray, mirrored
  std::uint64_t origin_address;
  std::uint64_t axis_mask[3];
  /// Where the voxels go: a bit each, and a byte for each brick that has any.
  std::uint64_t* table;
  std::uint8_t* touched;
  /// Or here, if there is no table.
  void (*put)(void* context, std::uint64_t word, std::uint64_t mask);
  void* context;
};

/// Rays of a kind that can be walked faster, by columns: see scan_slab_rays_avx512.h.
struct SlabRays {
  std::uint8_t* way;                           ///< 0: not of the kind; 1 to 4: main axis and direction, +x, -x, +y, -y
  std::uint32_t *slabs, *flags;                ///< faces across the main axis that it crosses
  std::uint32_t *slope, *fraction;             ///< faces across the other of x and y: a slab adds, crossed so far
  std::uint32_t *minor_slab, *minor_fraction;  ///< slab in which it next crosses a face across z
  std::uint32_t *minor_slabs, *minor_slabs_fraction;  ///< to the next such slab
  std::uint32_t *minor_middle, *minor_middles;        ///< faces across the other, modulo two, when it does; to the next
};
struct SlabInput {
  const Rays* rays;
  std::size_t count;
  std::uint32_t origin_key[3];
  const SlabRays* to;
  const std::uint32_t* order;  ///< rays to walk, by their ways
  std::size_t first[5];        ///< of each way, in `order`
};
struct SlabKernels {
  void (*sort_out)(const SlabInput& slabs);                     ///< which rays are of the kind
  void (*walk)(const SlabInput& slabs, const WalkInput& walk);  ///< those in `order`, into the table
};

struct CollectInput {
  std::uint64_t* free_table;  ///< of a chunk: 512 bricks of 8 words; wiped on the way
  std::uint64_t* hit_table;
  std::uint8_t* touched;  ///< 1 free, 2 hit
  Entry* entries;         ///< room for 512
  std::uint64_t* masks;   ///< room for 8,192
};
struct Collected {
  std::size_t entries;
  std::size_t masks;
};

struct UpdateInput {
  SensorModel model;
  Brick* const* bricks;  ///< one an entry; null: this entry changes nothing
  const Entry* entries;
  std::size_t count;
  const std::uint64_t* masks;
  std::uint8_t* emptied;  ///< one an entry: set if a block was given back
  Blocks* blocks;         ///< with at least 8 free ones an entry
};

struct Kernels {
  void (*start_rays)(const ScanInput& scan, const Rays& rays);
  void (*walk)(const WalkInput& walk);
  Collected (*collect)(const CollectInput& chunk);
  void (*update)(const UpdateInput& update);
  const SlabKernels* slabs;  ///< null: there are none
};

extern const SlabKernels kAvx512SlabKernels;
extern const Kernels kPortableKernels, kAvx2Kernels, kAvx512Kernels;

}  // namespace bricks

/// Throws InvalidValue if this processor does not know the set.
const bricks::Kernels& kernels_for(InstructionSet set);

}  // namespace uwsim
