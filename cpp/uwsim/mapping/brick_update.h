#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <vector>

#include "uwsim/mapping/brick_store.h"
#include "uwsim/mapping/scan_tracer.h"

namespace uwsim::bricks {

/// Inserts scans into a store: rays by scans, then voxels by chunks, each chunk's scans in their order. The result does
/// not depend on the number of threads nor on how scans are grouped.
class BrickUpdate {
 public:
  BrickUpdate(BrickStore& store, const Kernels& kernels);

  /// `scan(i)` gives the i-th of `count` scans; threads: at least 1.
  void insert(std::size_t count, const std::function<ScanInput(std::size_t)>& scan, int threads);

 private:
  /// Scans that are traced together, and where to. Those of the batch before are elsewhere.
  struct Batch {
    std::size_t first = 0, count = 0;
    std::size_t traces = 0;
  };
  /// A chunk's part of a scan.
  struct Part {
    std::uint64_t place;  ///< the chunk's code, then the trace: in the order in which they take effect
    std::size_t chunk;    ///< of that trace

    std::uint32_t code() const { return static_cast<std::uint32_t>(place >> 32); }
    std::uint32_t trace() const { return static_cast<std::uint32_t>(place); }
  };
  struct Group {
    BrickStore::Chunk* chunk;
    std::size_t first, end;  ///< parts
  };
  struct Worker;

  Batch batch_after(const Batch& batch, std::size_t count, std::size_t threads) const;
  void group();
  void update(std::atomic<std::size_t>& next_group);
  void apply(const Part& part, BrickStore::Chunk& chunk, BrickStore::Supply& supply, Worker& worker);

  BrickStore& store_;
  const Kernels& kernels_;
  std::vector<ScanTracer> tracers_;
  std::vector<ScanTrace> traces_;
  Batch batch_;
  std::vector<Part> parts_;
  std::vector<Group> groups_;
  std::size_t mask_bytes_a_scan_ = 0;  ///< of the scans before, to bound those of the next ones
};

}  // namespace uwsim::bricks
