#include "uwsim/mapping/brick_update.h"

#include <algorithm>
#include <barrier>
#include <exception>
#include <mutex>
#include <thread>

namespace uwsim::bricks {
namespace {

/// Scans go together while their masks fit here, for each thread: what a core's own cache may hold twice, with the
/// bricks they change.
constexpr std::size_t kMaskBytesTogether = 768 << 10;
constexpr std::size_t kScansTogether = 64;
/// Fewer would each fetch the same bricks from memory.
constexpr std::size_t kFewestTogether = 6;

/// Threads that do parts of a job together, one part after the other. What one of them throws ends the job: it is
/// thrown again where the team was made to work.
class Team {
 public:
  explicit Team(std::size_t threads) : threads_(threads), barrier_(static_cast<std::ptrdiff_t>(threads), End{this}) {}

  /// Runs job(thread, team) on each, this thread among them.
  template <typename Job>
  void run(const Job& job) {
    std::vector<std::jthread> others;
    others.reserve(threads_);
    for (std::size_t thread = 1; thread < threads_; ++thread) {
      try {
        others.emplace_back([&, thread] { job(thread, *this); });
      } catch (const std::exception&) {
        barrier_.arrive_and_drop();  // the system gives no more threads, or no memory for them: fewer do it all
      }
    }
    job(0, *this);
    others.clear();
    if (error_) std::rethrow_exception(error_);
  }

  /// A part of the job, for all; it ends when all have done theirs. False to all if it failed for any: that is the end.
  template <typename Part>
  bool together(const Part& part) {
    try {
      part();
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      error_ = std::current_exception();
    }
    barrier_.arrive_and_wait();
    return !has_failed_;
  }

 private:
  struct End {
    Team* team;
    void operator()() noexcept { team->has_failed_ = team->error_ != nullptr; }
  };

  const std::size_t threads_;
  bool has_failed_ = false;  ///< changes while all wait
  std::barrier<End> barrier_;
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace

struct BrickUpdate::Worker {
  Brick* bricks[512];
  std::uint8_t emptied[512];
};

BrickUpdate::BrickUpdate(BrickStore& store, const Kernels& kernels) : store_(store), kernels_(kernels) {}

/// Each batch is traced while bricks are updated by the one before it: the many small parts of that come last, so that
/// no thread waits for long.
void BrickUpdate::insert(std::size_t count, const std::function<ScanInput(std::size_t)>& scan, int threads) {
  const std::size_t team_size = std::min(count, static_cast<std::size_t>(threads));
  if (team_size == 0) return;
  while (tracers_.size() < team_size) tracers_.emplace_back(kernels_);
  traces_.resize(2 * kScansTogether);
  batch_ = {};
  std::atomic<std::size_t> next_group = 0, next_scan = 0;
  const auto plan = [&] {
    store_.make_room();
    group();
    batch_ = batch_after(batch_, count, team_size);
    next_group = next_scan = 0;
  };
  plan();
  Team(team_size).run([&](std::size_t thread, Team& team) {
    bool goes_on = true;
    const auto work = [&] {
      goes_on = batch_.count > 0;
      for (std::size_t i; (i = next_scan++) < batch_.count;) {
        tracers_[thread].trace(scan(batch_.first + i), traces_[batch_.traces + i]);
      }
      update(next_group);
    };
    const auto plan_on_one = [&] {
      if (thread == 0) plan();
    };
    while (team.together(work) && goes_on && team.together(plan_on_one)) {
    }
  });
  store_.make_room();
}

BrickUpdate::Batch BrickUpdate::batch_after(const Batch& batch, std::size_t count, std::size_t threads) const {
  const std::size_t first = batch.first + batch.count;
  const std::size_t fitting = mask_bytes_a_scan_ == 0 ? 0 : threads * kMaskBytesTogether / mask_bytes_a_scan_;
  const std::size_t fewest = mask_bytes_a_scan_ == 0 ? 1 : kFewestTogether;
  const std::size_t wanted = std::clamp(fitting, std::min(threads * fewest, kScansTogether), kScansTogether);
  return {first, std::min(count - first, wanted), kScansTogether - batch.traces};
}

/// The batch's traces by chunks.
void BrickUpdate::group() {
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
  std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.place < b.place; });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (i == 0 || parts_[i].code() != parts_[i - 1].code()) groups_.push_back({&store_.chunk(parts_[i].code()), i, i});
    groups_.back().end = i + 1;
  }
}

void BrickUpdate::update(std::atomic<std::size_t>& next_group) {
  BrickStore::Supply supply(store_);
  Worker worker;
  for (std::size_t i; (i = next_group++) < groups_.size();) {
    for (std::size_t part = groups_[i].first; part < groups_[i].end; ++part) {
      apply(parts_[part], *groups_[i].chunk, supply, worker);
    }
  }
}

void BrickUpdate::apply(const Part& part, BrickStore::Chunk& chunk, BrickStore::Supply& supply, Worker& worker) {
  const ScanTrace& trace = traces_[part.trace()];
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
