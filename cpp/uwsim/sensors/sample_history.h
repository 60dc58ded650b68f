#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

/// The vehicle at a sensor's last sampling times, in a ring of fixed size. Of what left the ring, the newest that was
/// not dropped stays known, so that a reader always finds what last came through.
class SampleHistory {
 public:
  struct Entry {
    Moment moment;
    bool dropped = false;
  };

  explicit SampleHistory(std::size_t capacity) : ring_(capacity) {}

  void push(const Moment& moment, bool dropped) {
    Entry& oldest = ring_[pushed_ % ring_.size()];
    if (pushed_ >= ring_.size() && !oldest.dropped) last_evicted_ = oldest;
    oldest = {moment, dropped};
    ++pushed_;
  }

  /// Newest first; of what left the ring, only the last that was not dropped.
  template <typename Visit>
  void visit_back(Visit&& stop_at) const {
    const std::size_t held = std::min<std::size_t>(pushed_, ring_.size());
    for (std::size_t age = 1; age <= held; ++age) {
      if (stop_at(ring_[(pushed_ - age) % ring_.size()])) return;
    }
    if (last_evicted_) stop_at(*last_evicted_);
  }

  /// Saves or restores all of it. Throws InvalidValue.
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
    archive(entry.moment.tick);
    archive(entry.moment.state);
    archive(entry.moment.acceleration_body);
    archive(entry.moment.touching);
    archive(entry.dropped);
  }

  std::vector<Entry> ring_;
  std::uint64_t pushed_ = 0;
  std::optional<Entry> last_evicted_;
};

}  // namespace uwsim
