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
    /// True if the reading below is the sample, which was taken with parameters that have changed since.
    bool settled = false;
    bool valid = false;
    std::uint64_t arrival_ns = 0;
    std::vector<double> reading;
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
    entry.observed = entry.settled = false;
    ++pushed_;
    return entry;
  }

  /// The entry added last, which is valid until the next but one is added; null before the first.
  const Entry* newest() const { return pushed_ == 0 ? nullptr : &ring_[(pushed_ - 1) % ring_.size()]; }

  /// Visits the entries from newest to oldest, then the one kept separately, until `stop_at` returns true.
  template <typename Visit>
  void visit_back(Visit&& stop_at) const {
    for (std::uint64_t age = 1; age <= held(); ++age) {
      if (stop_at(ring_[(pushed_ - age) % ring_.size()])) return;
    }
    if (evicted_) stop_at(last_evicted_);
  }

  /// Visits every entry.
  template <typename Visit>
  void visit_all(Visit&& visit) {
    for (std::uint64_t age = held(); age > 0; --age) visit(aged(age));
    if (evicted_) visit(last_evicted_);
  }

  /// Takes over the entries of another history of the same kind; a smaller history keeps only the newest.
  void take_over(const SampleHistory& other) {
    pushed_ = 0;
    evicted_ = other.evicted_;
    last_evicted_ = other.last_evicted_;
    for (std::uint64_t age = other.held(); age > 0; --age) {
      const Entry& entry = other.ring_[(other.pushed_ - age) % other.ring_.size()];
      push(entry.snapshot, entry.dropped) = entry;
    }
  }

  /// Saves or restores the entries at `tick`; a smaller history keeps only the newest. Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick) {
    std::uint64_t count = held();
    archive(count);
    archive(evicted_);
    if (evicted_) exchange_entry(archive, last_evicted_, tick);
    if (archive.restoring()) {
      restore_entries(archive, count, tick);
    } else {
      for (std::uint64_t age = count; age > 0; --age) exchange_entry(archive, aged(age), tick);
    }
  }

  /// Saves or restores what exchange_state, which must be called first, leaves out: the station's place at each entry,
  /// and settled readings, of this width. Throws InvalidValue.
  void exchange_details(StateArchive& archive, std::size_t width) {
    std::uint64_t count = held();
    archive(count);
    Entry spare;
    for (std::uint64_t age = count; age > 0; --age)
      exchange_details_of(archive, age <= held() ? aged(age) : spare, width);
    if (evicted_) exchange_details_of(archive, last_evicted_, width);
  }

 private:
  std::uint64_t held() const { return std::min<std::uint64_t>(pushed_, ring_.size()); }
  Entry& aged(std::uint64_t age) { return ring_[(pushed_ - age) % ring_.size()]; }

  static void exchange_details_of(StateArchive& archive, Entry& entry, std::size_t width) {
    for (double& each : entry.snapshot.station_world_m) archive(each);
    archive(entry.settled);
    if (!entry.settled) return;
    archive(entry.valid);
    archive(entry.arrival_ns);
    entry.reading.resize(width);
    for (double& each : entry.reading) {
      auto bits = std::bit_cast<std::uint64_t>(each);  // readings may be infinite or NaN
      archive(bits);
      each = std::bit_cast<double>(bits);
    }
  }

  void restore_entries(StateArchive& archive, std::uint64_t count, std::uint64_t tick) {
    pushed_ = 0;
    last_evicted_.settled = false;
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
