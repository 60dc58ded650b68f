#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The vehicle at a sensor's last sampling times, in a ring of fixed size. The newest entry that has left the ring and
/// was not dropped is kept as well, so that a read always finds the last sample that was not dropped.
class SampleHistory {
 public:
  struct Entry {
    VehicleSnapshot snapshot;
    bool dropped = false;
  };

  explicit SampleHistory(std::size_t capacity) : ring_(capacity) {}

  void push(const VehicleSnapshot& snapshot, bool dropped) {
    Entry& oldest = ring_[pushed_ % ring_.size()];
    if (pushed_ >= ring_.size() && !oldest.dropped) last_evicted_ = oldest;
    oldest = {snapshot, dropped};
    ++pushed_;
  }

  /// Visits the entries, newest first, then the kept one, until `stop_at` returns true.
  template <typename Visit>
  void visit_back(Visit&& stop_at) const {
    const std::size_t held = std::min<std::size_t>(pushed_, ring_.size());
    for (std::size_t age = 1; age <= held; ++age) {
      if (stop_at(ring_[(pushed_ - age) % ring_.size()])) return;
    }
    if (last_evicted_) stop_at(*last_evicted_);
  }

  /// Saves or restores the entries. Throws InvalidValue.
  void exchange_state(StateArchive& archive) {
    archive.same("history", ring_.size());
    archive(pushed_);
    for (std::size_t k = 0; k < std::min<std::size_t>(pushed_, ring_.size()); ++k) exchange_entry(archive, ring_[k]);
    bool evicted = last_evicted_.has_value();
    archive(evicted);
    if (!evicted) last_evicted_.reset();
    if (evicted) exchange_entry(archive, last_evicted_ ? *last_evicted_ : last_evicted_.emplace());
  }

 private:
  static void exchange_entry(StateArchive& archive, Entry& entry) {
    archive(entry.snapshot.tick);
    archive(entry.snapshot.state);
    archive(entry.snapshot.acceleration_body);
    archive(entry.snapshot.touching);
    archive(entry.dropped);
  }

  std::vector<Entry> ring_;
  std::uint64_t pushed_ = 0;
  std::optional<Entry> last_evicted_;
};

}  // namespace uwsim
