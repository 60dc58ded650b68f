#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "uwsim/mapping/growing.h"
#include "uwsim/mapping/scan_kernels.h"
#include "uwsim/mapping/scan_tables.h"

namespace uwsim::bricks {

/// What one scan does to a map: entries by chunks of 8 x 8 x 8 bricks.
struct ScanTrace {
  struct Chunk {
    std::uint32_t code;  ///< Morton code of its key: a voxel's, less six bits an axis
    std::uint32_t first_entry;
    std::uint32_t entries;
    std::size_t first_mask;
  };
  std::vector<Chunk> chunks;
  Growing<Entry> entries;
  Growing<std::uint64_t> masks;

  void clear();
};

/// Walks a scan's rays: every voxel on the way to a point free, every voxel with a point in it hit, none of them both.
/// Voxels are gathered as bits of a table that covers the scan; a scan too wide for that goes through a hash instead.
/// One a thread.
class ScanTracer {
 public:
  explicit ScanTracer(const Kernels& kernels) : kernels_(kernels) {}

  /// Overwrites `trace`. Points and origin must lie within OctoMap's cube, less its outermost voxels.
  void trace(const ScanInput& scan, ScanTrace& trace);

 private:
  using Key = std::array<std::uint32_t, 3>;

  /// Where voxels lie in the table: 18 bits within a chunk in Morton order, above them the chunk's x, y and z.
  struct Layout {
    Key first_chunk;
    Key chunks;
    std::array<int, 3> shift;
    std::array<std::uint64_t, 3> axis_mask;
    bool in_table;

    std::uint64_t address(const Key& key) const;
  };

  void make_room(std::size_t rays);
  void make_slab_room(std::size_t rays);
  Layout layout_of(std::size_t count, const Key& origin) const;
  void sort_out_slabs(std::size_t count, const Key& origin);
  void aim(std::size_t count, const Layout& layout);
  void walk(const Layout& layout, std::uint64_t origin_address);
  void mark_hits(std::size_t count, const Layout& layout);
  void collect(const Layout& layout, ScanTrace& trace);
  void collect_wide(ScanTrace& trace);

  const Kernels& kernels_;
  std::size_t capacity_ = 0;
  std::vector<double> columns_;
  std::vector<std::uint16_t> keys_;
  std::vector<std::uint8_t> flags_;
  std::vector<std::uint32_t> steps_, order_;
  std::vector<std::uint64_t> address_, end_address_;
  Rays rays_{};
  std::vector<std::uint32_t> slab_columns_, slab_order_;
  std::vector<std::uint8_t> way_;
  SlabRays slab_rays_{};
  SlabInput slabs_{};
  ScanTables tables_;

  struct WideBrick {
    std::uint64_t free[8] = {}, hit[8] = {};
  };
  std::unordered_map<std::uint64_t, WideBrick> wide_;
};

}  // namespace uwsim::bricks
