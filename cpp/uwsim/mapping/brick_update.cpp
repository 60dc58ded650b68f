#include "uwsim/mapping/brick_update.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <tuple>

namespace uwsim::bricks {
namespace {

/// Scans go together while their masks fit here: what a core's own cache may hold with the bricks they change.
constexpr std::size_t kMaskBytesTogether = 4 << 20;
constexpr std::size_t kScansTogether = 64;

/// Runs work(thread) for each thread; what one throws is thrown here, when all are done.
template <typename Work>
void run_on(std::size_t threads, const Work& work) {
  std::vector<std::exception_ptr> errors(threads);
  const auto guarded = [&](std::size_t thread) {
    try {
      work(thread);
    } catch (...) {
      errors[thread] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t thread = 1; thread < threads; ++thread) others.emplace_back(guarded, thread);
    guarded(0);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace

struct BrickUpdate::Worker {
  Brick* bricks[512];
  std::uint8_t emptied[512];
};

BrickUpdate::BrickUpdate(BrickStore& store, const Kernels& kernels) : store_(store), kernels_(kernels) {}

void BrickUpdate::insert(std::size_t count, const std::function<ScanInput(std::size_t)>& scan, int threads) {
  for (std::size_t first = 0; first < count;) {
    const std::size_t fitting = mask_bytes_a_scan_ == 0 ? 1 : kMaskBytesTogether / mask_bytes_a_scan_;
    const std::size_t wanted = std::clamp<std::size_t>(fitting, static_cast<std::size_t>(threads), kScansTogether);
    const std::size_t together = std::min(count - first, wanted);
    insert_together(first, together, scan, std::min(together, static_cast<std::size_t>(threads)));
    first += together;
  }
}

void BrickUpdate::insert_together(std::size_t first, std::size_t count,
                                  const std::function<ScanInput(std::size_t)>& scan, std::size_t threads) {
  while (tracers_.size() < threads) tracers_.emplace_back(kernels_);
  if (traces_.size() < count) traces_.resize(count);
  std::atomic<std::size_t> next_scan = 0, next_group = 0;
  run_on(threads, [&](std::size_t thread) {
    for (std::size_t i; (i = next_scan++) < count;) tracers_[thread].trace(scan(first + i), traces_[i]);
  });
  group(count);
  run_on(std::min(threads, std::max<std::size_t>(groups_.size(), 1)), [&](std::size_t) {
    BrickStore::Supply supply(store_);
    Worker worker;
    for (std::size_t i; (i = next_group++) < groups_.size();) {
      for (std::size_t part = groups_[i].first; part < groups_[i].end; ++part) {
        apply(parts_[part], *groups_[i].chunk, supply, worker);
      }
    }
  });
}

void BrickUpdate::group(std::size_t count) {
  parts_.clear();
  groups_.clear();
  std::size_t masks = 0;
  for (std::size_t scan = 0; scan < count; ++scan) {
    masks += traces_[scan].masks.size();
    for (std::size_t chunk = 0; chunk < traces_[scan].chunks.size(); ++chunk) {
      parts_.push_back(
          {traces_[scan].chunks[chunk].code, static_cast<std::uint32_t>(scan), static_cast<std::uint32_t>(chunk)});
    }
  }
  mask_bytes_a_scan_ = std::max<std::size_t>(1, masks * sizeof(std::uint64_t) / count);
  std::sort(parts_.begin(), parts_.end(),
            [](const Part& a, const Part& b) { return std::tie(a.code, a.scan) < std::tie(b.code, b.scan); });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (i == 0 || parts_[i].code != parts_[i - 1].code) groups_.push_back({&store_.chunk(parts_[i].code), i, i});
    groups_.back().end = i + 1;
  }
}

void BrickUpdate::apply(const Part& part, BrickStore::Chunk& chunk, BrickStore::Supply& supply, Worker& worker) {
  const ScanTrace& trace = traces_[part.scan];
  const ScanTrace::Chunk& found = trace.chunks[part.chunk];
  const Entry* const entries = trace.entries.data() + found.first_entry;
  for (std::size_t i = 0; i < found.entries; ++i) {
    std::uint32_t& slot = chunk.bricks[entries[i].brick];
    const bool uniform = slot != kNone && slot >= BrickStore::kUniform;
    const bool settled = uniform && entries[i].hit_words == 0 &&
                         (store_.uniform(slot) <= store_.model().lowest || store_.model().miss == 0);
    worker.bricks[i] = settled ? nullptr : &supply.open(slot);
    if (!settled) {
      __builtin_prefetch(worker.bricks[i]->known);
      __builtin_prefetch(worker.bricks[i]->low);
      __builtin_prefetch(worker.bricks[i]->block);
    }
  }
  kernels_.update({store_.model(), worker.bricks, entries, found.entries, trace.masks.data() + found.first_mask,
                   worker.emptied, &supply.blocks(8 * found.entries)});
  for (std::size_t i = 0; i < found.entries; ++i) {
    if (worker.emptied[i]) supply.close(chunk.bricks[entries[i].brick]);
  }
}

}  // namespace uwsim::bricks
