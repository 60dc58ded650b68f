#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The vehicle's state at a sensor's last sampling times, in a ring buffer of fixed size. The newest entry that has
/// left the ring and was not dropped is kept as well, so a read always finds the last sample that was not dropped.
class SampleHistory {
 public:
  struct Entry {
    VehicleSnapshot snapshot;
    bool dropped = false;
    bool observed = false;    ///< whether `raw` contains the observed values; if not, they are observed later
    std::vector<double> raw;  ///< of fixed size
  };

  /// `raw_width`: the number of raw values; 0 for a sensor that never observes immediately. `capacity`: at least 2.
  SampleHistory(std::size_t capacity, std::size_t raw_width) : ring_(capacity) {
    for (Entry& entry : ring_) entry.raw.resize(raw_width);
    last_evicted_.raw.resize(raw_width);
  }

  /// Adds an entry without raw values and returns it.
  Entry& push(const VehicleSnapshot& snapshot, bool dropped) {
    Entry& entry = ring_[pushed_ % ring_.size()];
    if (pushed_ >= ring_.size() && !entry.dropped) {
      std::swap(last_evicted_, entry);
      evicted_ = true;
    }
    entry.snapshot = snapshot;
    entry.dropped = dropped;
    entry.observed = false;
    ++pushed_;
    return entry;
  }

  /// The entry added last, which is valid until the next but one is added; null before the first.
  const Entry* newest() const { return pushed_ == 0 ? nullptr : &ring_[(pushed_ - 1) % ring_.size()]; }

  /// Visits the entries from newest to oldest, then the one kept separately, until `stop_at` returns true.
  template <typename Visit>
  void visit_back(Visit&& stop_at) const {
    const std::size_t held = std::min<std::size_t>(pushed_, ring_.size());
    for (std::size_t age = 1; age <= held; ++age) {
      if (stop_at(ring_[(pushed_ - age) % ring_.size()])) return;
    }
    if (evicted_) stop_at(last_evicted_);
  }

  /// Saves or restores the entries at `tick`; a smaller history keeps only the newest. Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick) {
    std::uint64_t held = std::min<std::uint64_t>(pushed_, ring_.size());
    archive(held);
    archive(evicted_);
    if (evicted_) exchange_entry(archive, last_evicted_, tick);
    if (archive.restoring()) {
      restore_entries(archive, held, tick);
    } else {
      for (std::uint64_t age = held; age > 0; --age)
        exchange_entry(archive, ring_[(pushed_ - age) % ring_.size()], tick);
    }
  }

 private:
  void restore_entries(StateArchive& archive, std::uint64_t count, std::uint64_t tick) {
    pushed_ = 0;
    Entry entry = last_evicted_;  // already has the right size
    for (std::uint64_t k = 0; k < count; ++k) {
      exchange_entry(archive, entry, tick);
      Entry& kept = push(entry.snapshot, entry.dropped);
      kept.observed = entry.observed;
      kept.raw = entry.raw;
    }
  }

  static void exchange_entry(StateArchive& archive, Entry& entry, std::uint64_t tick) {
    archive(entry.snapshot.tick);
    require(entry.snapshot.tick <= tick, "state.history.tick", entry.snapshot.tick, "must not lie ahead");
    archive(entry.snapshot.state);
    archive(entry.snapshot.acceleration_body);
    archive(entry.snapshot.touching);
    archive(entry.dropped);
    archive(entry.observed);
    require(!entry.observed || !entry.raw.empty(), "state.history.observed", 1, "must be 0 without rays");
    for (std::size_t k = 0; entry.observed && k < entry.raw.size(); ++k) {
      auto bits = std::bit_cast<std::uint64_t>(entry.raw[k]);  // infinite if the ray hit nothing
      archive(bits);
      entry.raw[k] = std::bit_cast<double>(bits);
      require(!std::isnan(entry.raw[k]), "state.history", entry.raw[k], "must not be NaN");
    }
  }

  std::vector<Entry> ring_;
  std::uint64_t pushed_ = 0;
  bool evicted_ = false;
  Entry last_evicted_;
};

}  // namespace uwsim
