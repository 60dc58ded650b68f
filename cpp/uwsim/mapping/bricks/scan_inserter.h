#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <vector>

#include "uwsim/mapping/bricks/brick_allocator.h"
#include "uwsim/mapping/bricks/brick_store.h"
#include "uwsim/mapping/bricks/scan_tracer.h"

namespace uwsim::bricks {

/// Inserts scans into a store. Scans are traced in parallel, in batches. The traces of a batch are then grouped by
/// chunk, and chunks are updated in parallel, each with its scans in order. The result depends neither on the number of
/// threads nor on how scans are divided into batches.
class ScanInserter {
 public:
  ScanInserter(BrickStore& store, const Kernels& kernels);

  /// `scan(i)` returns the i-th of `count` scans; threads: at least 1.
  void insert(std::size_t count, const std::function<ScanInput(std::size_t)>& scan, int threads);

 private:
  /// Scans that are traced together. Their traces start at index `traces` in traces_; those of the previous batch are
  /// in the other half of traces_.
  struct Batch {
    std::size_t first = 0, count = 0;
    std::size_t traces = 0;
  };
  /// The effect of one scan on one chunk.
  struct Part {
    std::uint64_t order;  ///< the chunk's code, then the index of the trace: parts are applied in this order
    std::size_t chunk;    ///< index of the chunk in the trace

    std::uint32_t code() const { return static_cast<std::uint32_t>(order >> 32); }
    std::uint32_t trace() const { return static_cast<std::uint32_t>(order); }
  };
  /// All parts of one chunk.
  struct Group {
    BrickStore::Chunk* chunk;
    std::size_t first, end;  ///< indices into parts_
  };
  struct Scratch;

  Batch batch_after(const Batch& batch, std::size_t count, std::size_t threads) const;
  void group_by_chunk();
  void update_chunks(std::atomic<std::size_t>& next_group);
  void apply(const Part& part, BrickStore::Chunk& chunk, BrickAllocator& allocator, Scratch& scratch);

  BrickStore& store_;
  const Kernels& kernels_;
  std::vector<ScanTracer> tracers_;  ///< one per thread
  std::vector<ScanTrace> traces_;
  Batch batch_;
  std::vector<Part> parts_;
  std::vector<Group> groups_;
  std::size_t mask_bytes_a_scan_ = 0;  ///< average of the last batch; determines the size of the next batch
};

}  // namespace uwsim::bricks
