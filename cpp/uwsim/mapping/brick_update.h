#pragma once

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
  /// A chunk's part of a scan.
  struct Part {
    std::uint32_t code;
    std::uint32_t scan;
    std::uint32_t chunk;  ///< of that scan's trace
  };
  struct Group {
    BrickStore::Chunk* chunk;
    std::size_t first, end;  ///< parts
  };
  struct Worker;

  void insert_together(std::size_t first, std::size_t count, const std::function<ScanInput(std::size_t)>& scan,
                       std::size_t threads);
  void group(std::size_t count);
  void apply(const Part& part, BrickStore::Chunk& chunk, BrickStore::Supply& supply, Worker& worker);

  BrickStore& store_;
  const Kernels& kernels_;
  std::vector<ScanTracer> tracers_;
  std::vector<ScanTrace> traces_;
  std::vector<Part> parts_;
  std::vector<Group> groups_;
  std::size_t mask_bytes_a_scan_ = 0;  ///< of the scans before, to bound those of the next ones
};

}  // namespace uwsim::bricks
