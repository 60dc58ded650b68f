#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "uwsim/mapping/bricks/address_layout.h"
#include "uwsim/mapping/bricks/kernels/scan_kernels.h"
#include "uwsim/mapping/bricks/scan_bitmap.h"
#include "uwsim/mapping/bricks/uninitialised_vector.h"

namespace uwsim::bricks {

/// The voxels that one scan misses and hits, sorted by chunk and brick.
struct ScanTrace {
  struct Chunk {
    /// Morton code of the chunk's key: the key of any of its voxels without the six lowest bits along each axis
    std::uint32_t code;
    std::uint32_t first_entry;
    std::uint32_t entries;
    std::size_t first_mask;
  };
  std::vector<Chunk> chunks;
  UninitialisedVector<TraceEntry> entries;
  UninitialisedVector<std::uint64_t> masks;

  void clear();
};

/// Traces the rays of a scan: every voxel that contains a point is hit, and every other voxel that a ray passes through
/// is missed. Voxels are marked in a bitmap of the box around the scan, or in a hash table if the box is too large for
/// a bitmap. Each thread needs its own tracer.
class ScanTracer {
 public:
  explicit ScanTracer(const Kernels& kernels) : kernels_(kernels) {}

  /// Overwrites `trace`. Points and origin must lie within OctoMap's cube, excluding its outermost voxels.
  void trace(const ScanInput& scan, ScanTrace& trace);

 private:
  using Key = AddressLayout::Key;

  void reserve(std::size_t rays);
  void find_addresses(std::size_t count, const AddressLayout& layout);
  void sort_walks(std::size_t count);
  void walk(const AddressLayout& layout, std::uint64_t origin_address);
  void mark_hits(std::size_t count, const AddressLayout& layout);
  void collect(const AddressLayout& layout, ScanTrace& trace);
  void collect_wide(ScanTrace& trace);

  const Kernels& kernels_;
  std::size_t capacity_ = 0;  ///< number of rays for which there is room
  std::vector<double> columns_;
  std::vector<std::uint16_t> keys_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint32_t> steps_, order_;
  std::vector<std::uint64_t> address_, end_address_;
  Rays rays_{};  ///< points into the vectors above
  ScanBitmap bitmap_;

  struct WideBrick {
    std::uint64_t missed[8] = {}, hit[8] = {};
  };
  std::unordered_map<std::uint64_t, WideBrick> wide_;  ///< by the Morton code of a brick
};

}  // namespace uwsim::bricks
