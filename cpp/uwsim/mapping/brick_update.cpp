#include "uwsim/mapping/brick_update.h"

#include <algorithm>
#include <atomic>
#include <barrier>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <tuple>

namespace uwsim::bricks {
namespace {

/// Scans go together while their masks fit here: what a core's own cache may hold with the bricks they change.
constexpr std::size_t kMaskBytesTogether = 3 << 20;
constexpr std::size_t kScansTogether = 64;

/// Threads that do parts of a job together, one part after the other. What one of them throws ends the job: it is
/// thrown again where the team was made to work.
class Team {
 public:
  explicit Team(std::size_t threads) : threads_(threads), barrier_(static_cast<std::ptrdiff_t>(threads)) {}

  /// Runs job(thread, team) on each, this thread among them.
  template <typename Job>
  void run(const Job& job) {
    std::vector<std::jthread> others;
    others.reserve(threads_);
    for (std::size_t thread = 1; thread < threads_; ++thread) {
      try {
        others.emplace_back([&, thread] { job(thread, *this); });
      } catch (const std::system_error&) {
        barrier_.arrive_and_drop();  // the system gives no more threads: fewer do it all
      }
    }
    job(0, *this);
    others.clear();
    if (error_) std::rethrow_exception(error_);
  }

  /// A part of the job, for all; it ends when all have done theirs.
  template <typename Part>
  void together(const Part& part) {
    if (!failed_) {
      try {
        part();
      } catch (...) {
        const std::scoped_lock lock(mutex_);
        error_ = std::current_exception();
        failed_ = true;
      }
    }
    barrier_.arrive_and_wait();
  }

 private:
  const std::size_t threads_;
  std::barrier<> barrier_;
  std::mutex mutex_;
  std::atomic<bool> failed_ = false;
  std::exception_ptr error_;
};

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
    store_.make_room();
  }
}

void BrickUpdate::insert_together(std::size_t first, std::size_t count,
                                  const std::function<ScanInput(std::size_t)>& scan, std::size_t threads) {
  while (tracers_.size() < threads) tracers_.emplace_back(kernels_);
  if (traces_.size() < count) traces_.resize(count);
  std::atomic<std::size_t> next_scan = 0, next_group = 0;
  Team(threads).run([&](std::size_t thread, Team& team) {
    team.together([&] {
      for (std::size_t i; (i = next_scan++) < count;) tracers_[thread].trace(scan(first + i), traces_[i]);
    });
    team.together([&] {
      if (thread == 0) group(count);
    });
    team.together([&] {
      BrickStore::Supply supply(store_);
      Worker worker;
      for (std::size_t i; (i = next_group++) < groups_.size();) {
        for (std::size_t part = groups_[i].first; part < groups_[i].end; ++part) {
          apply(parts_[part], *groups_[i].chunk, supply, worker);
        }
      }
    });
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
