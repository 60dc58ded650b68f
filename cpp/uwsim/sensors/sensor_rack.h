#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/sensors/noisy_sensor.h"

namespace uwsim {

/// The sensors of one vehicle, and the tick at which the next sample is due.
class SensorRack {
 public:
  SensorRack() = default;
  SensorRack(const std::vector<SensorSpec>& specs, std::uint64_t seed, std::string_view vehicle,
             std::uint64_t step_ns) {
    for (const SensorSpec& spec : specs) {
      for (const NoisySensor& other : sensors_) {
        require(other.spec().name != spec.name, "sensors.name", spec.name, "must be unique");
      }
      sensors_.emplace_back(spec, seed, vehicle, step_ns);
    }
    find_next_due();
  }

  std::size_t size() const { return sensors_.size(); }
  NoisySensor& at(std::size_t index) { return sensors_.at(index); }
  const NoisySensor& at(std::size_t index) const { return sensors_.at(index); }

  /// Whether the snapshot of `tick` must be recorded before the next step. In most steps, this comparison is the only
  /// cost.
  bool due(std::uint64_t tick) const { return tick >= next_due_; }
  /// Returns true if a sensor that is due casts rays; otherwise `record` needs no other bodies in the scene.
  bool casts_rays(const VehicleSnapshot& snapshot) const {
    for (std::size_t k = 0; k < due_.size(); ++k) {
      if (snapshot.tick >= due_[k] && sensors_[k].casts_rays(snapshot.state.world_from_body)) return true;
    }
    return false;
  }
  /// Does not allocate or free memory.
  void record(const VehicleSnapshot& snapshot, const Surroundings& around) {
    next_due_ = NoisySensor::kNever;
    for (std::size_t k = 0; k < due_.size(); ++k) {
      if (snapshot.tick >= due_[k]) {
        sensors_[k].record(snapshot, around);
        due_[k] = sensors_[k].next_due();
      }
      next_due_ = std::min(next_due_, due_[k]);
    }
  }

  /// Whether a watched sensor's sample may have arrived.
  bool collection_due(std::uint64_t tick) const { return tick >= next_collection_; }
  void collect(const VehicleSnapshot& now, const Surroundings& around) {
    for (NoisySensor& sensor : sensors_) sensor.collect(now, around);
    find_next_collection();
  }
  void watch(std::size_t index, std::optional<std::uint64_t> from_ns) {
    sensors_.at(index).watch(from_ns);
    find_next_collection();
  }
  /// See NoisySensor.
  void settle(const Surroundings& around) {
    for (NoisySensor& sensor : sensors_) sensor.settle(around);
  }
  void take_over(const SensorRack& before) {
    for (std::size_t k = 0; k < sensors_.size(); ++k) sensors_[k].take_over(before.sensors_.at(k));
  }
  void exchange_details(StateArchive& archive) {
    for (NoisySensor& sensor : sensors_) sensor.exchange_details(archive);
  }
  /// Watches the same sensors as another rack.
  void watch_like(const SensorRack& other) {
    for (std::size_t k = 0; k < sensors_.size(); ++k) sensors_[k].watch_like(other.sensors_.at(k));
    find_next_collection();
  }

  /// See NoisySensor.
  void use_link(bool has_modems) {
    for (NoisySensor& sensor : sensors_) sensor.use_link(has_modems);
  }
  void answer(std::size_t index, const VehicleSnapshot& asked, bool given_up, std::uint64_t now) {
    sensors_.at(index).answer(asked, given_up, now);
    find_next_collection();
  }

  /// Saves or restores every sensor at `tick`. Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick) {
    archive.same("sensors", sensors_.size());
    for (NoisySensor& sensor : sensors_) sensor.exchange_state(archive, tick);
    find_next_due();
  }

 private:
  void find_next_due() {
    due_.clear();
    next_due_ = NoisySensor::kNever;
    for (const NoisySensor& sensor : sensors_) {
      due_.push_back(sensor.next_due());
      next_due_ = std::min(next_due_, due_.back());
    }
  }

  void find_next_collection() {
    next_collection_ = NoisySensor::kNever;
    for (const NoisySensor& sensor : sensors_) next_collection_ = std::min(next_collection_, sensor.next_collection());
  }

  std::vector<NoisySensor> sensors_;
  std::vector<std::uint64_t> due_;  ///< next_due() of each sensor, since the sensors of a fleet do not fit in the cache
  std::uint64_t next_collection_ = NoisySensor::kNever;
  std::uint64_t next_due_ = NoisySensor::kNever;
};

}  // namespace uwsim
