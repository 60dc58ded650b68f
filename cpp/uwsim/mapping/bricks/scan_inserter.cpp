#include "uwsim/mapping/bricks/scan_inserter.h"

#include <algorithm>

#include "uwsim/core/thread_team.h"

namespace uwsim::bricks {
namespace {

/// Bytes of masks in a batch, per thread: half the size of a core's private cache, which leaves room for the bricks
/// that the masks change.
constexpr std::size_t kMaskBytesTogether = 768 << 10;
constexpr std::size_t kMostTogether = 64;
/// Minimum number of scans per thread; with fewer, each batch would fetch the same bricks from memory again.
constexpr std::size_t kFewestTogether = 6;

}  // namespace

/// One thread's working memory for the bricks of one part.
struct ScanInserter::Scratch {
  Brick* bricks[512];
  std::uint8_t freed_block[512];
};

ScanInserter::ScanInserter(BrickStore& store, const Kernels& kernels) : store_(store), kernels_(kernels) {}

/// In each phase, the threads trace one batch and update the chunks of the previous one. The updates come last because
/// they are many and small, so that no thread waits for long.
void ScanInserter::insert(std::size_t count, const std::function<ScanInput(std::size_t)>& scan, int threads) {
  const std::size_t team_size = std::min(count, static_cast<std::size_t>(threads));
  if (team_size == 0) return;
  while (tracers_.size() < team_size) tracers_.emplace_back(kernels_);
  traces_.resize(2 * kMostTogether);
  batch_ = {};
  std::atomic<std::size_t> next_group = 0, next_scan = 0;
  const auto plan = [&] {
    group_by_chunk();
    batch_ = batch_after(batch_, count, team_size);
    next_group = next_scan = 0;
  };
  plan();
  ThreadTeam team(team_size);
  team.run([&](std::size_t thread) {
    bool more = true;
    const auto trace_and_update = [&] {
      more = batch_.count > 0;
      for (std::size_t i; (i = next_scan++) < batch_.count;) {
        tracers_[thread].trace(scan(batch_.first + i), traces_[batch_.traces + i]);
      }
      update_chunks(next_group);
    };
    const auto plan_on_one_thread = [&] {
      if (thread == 0) plan();
    };
    while (team.phase(trace_and_update) && more && team.phase(plan_on_one_thread)) {
    }
  });
}

ScanInserter::Batch ScanInserter::batch_after(const Batch& batch, std::size_t count, std::size_t threads) const {
  const std::size_t first = batch.first + batch.count;
  const std::size_t fitting = mask_bytes_a_scan_ == 0 ? 0 : threads * kMaskBytesTogether / mask_bytes_a_scan_;
  const std::size_t fewest = mask_bytes_a_scan_ == 0 ? 1 : kFewestTogether;
  const std::size_t wanted = std::clamp(fitting, std::min(threads * fewest, kMostTogether), kMostTogether);
  return {first, std::min(count - first, wanted), kMostTogether - batch.traces};
}

/// Groups the traces of the batch by chunk.
void ScanInserter::group_by_chunk() {
  parts_.clear();
  groups_.clear();
  std::size_t masks = 0;
  for (std::size_t scan = batch_.traces; scan < batch_.traces + batch_.count; ++scan) {
    masks += traces_[scan].masks.size();
    for (std::size_t chunk = 0; chunk < traces_[scan].chunks.size(); ++chunk) {
      parts_.push_back({std::uint64_t{traces_[scan].chunks[chunk].code} << 32 | scan, chunk});
    }
  }
  if (batch_.count > 0) mask_bytes_a_scan_ = std::max<std::size_t>(1, masks * sizeof(std::uint64_t) / batch_.count);
  std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.order < b.order; });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (i == 0 || parts_[i].code() != parts_[i - 1].code())
      groups_.push_back({&store_.writable_chunk(parts_[i].code()), i, i});
    groups_.back().end = i + 1;
  }
}

void ScanInserter::update_chunks(std::atomic<std::size_t>& next_group) {
  BrickAllocator allocator(store_);
  Scratch scratch;
  for (std::size_t i; (i = next_group++) < groups_.size();) {
    for (std::size_t part = groups_[i].first; part < groups_[i].end; ++part) {
      apply(parts_[part], *groups_[i].chunk, allocator, scratch);
    }
  }
}

void ScanInserter::apply(const Part& part, BrickStore::Chunk& chunk, BrickAllocator& allocator, Scratch& scratch) {
  const ScanTrace& trace = traces_[part.trace()];
  const ScanTrace::Chunk& found = trace.chunks[part.chunk];
  const TraceEntry* const entries = trace.entries.data() + found.first_entry;
  for (std::size_t i = 0; i < found.entries; ++i) {
    std::uint32_t& slot = chunk.bricks[entries[i].brick];
    const bool uniform = slot != kNone && slot >= BrickStore::kUniform;
    const bool unchanged = uniform && entries[i].hit_words == 0 &&
                           (store_.uniform(slot) <= store_.model().clamping_min || store_.model().miss == 0);
    scratch.bricks[i] = unchanged ? nullptr : &allocator.writable(slot);
    if (!unchanged) {
      __builtin_prefetch(scratch.bricks[i]->known);
      __builtin_prefetch(scratch.bricks[i]->at_min);
      __builtin_prefetch(scratch.bricks[i]->block);
    }
  }
  kernels_.update({store_.model(), scratch.bricks, entries, found.entries, trace.masks.data() + found.first_mask,
                   scratch.freed_block, &allocator.blocks(8 * found.entries)});
  for (std::size_t i = 0; i < found.entries; ++i) {
    if (scratch.freed_block[i]) allocator.compact(chunk.bricks[entries[i].brick]);
  }
}

}  // namespace uwsim::bricks
