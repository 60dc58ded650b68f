#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "uwsim/sensors/noise.h"
#include "uwsim/sensors/sample_clock.h"
#include "uwsim/sensors/sample_history.h"
#include "uwsim/sensors/sample_watch.h"
#include "uwsim/sensors/sensor.h"

namespace uwsim {

struct Sample {
  std::vector<double> values;  ///< the fields of the kind, concatenated
  std::uint64_t stamp_ns = 0;  ///< the time of the measurement
  bool valid = false;
};

/// A sensor with its errors, rate, latency and drop-outs. A read returns the newest sample that has arrived, with the
/// time of its measurement. If that sample was dropped, the read returns the last one that was not dropped, marked
/// invalid; before the first sample has arrived, it returns the present value, marked invalid. Samples depend on seed,
/// names and time, not on when the sensor is read.
class NoisySensor {
 public:
  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

  /// Throws InvalidValue for an unknown kind, parameter or channel, or a value out of range.
  NoisySensor(const SensorSpec& spec, std::uint64_t seed, std::string_view vehicle, std::uint64_t step_ns);

  const SensorSpec& spec() const { return spec_; }
  const SensorKind& kind() const { return *kind_; }

  /// The next tick whose snapshot must be recorded; kNever for a sensor that only measures the present.
  std::uint64_t next_due() const { return next_due_; }
  /// Returns true if a measurement with the vehicle there casts rays.
  bool casts_rays(const Pose& world_from_body) const { return sensor_->rays(world_from_body).has_value(); }
  /// Stores the snapshot for later samples. A sensor whose rays may hit another body observes immediately, because
  /// bodies move; other sensors observe when they are read.
  void record(const VehicleSnapshot& snapshot, const Surroundings& around);

  /// The reference is valid until the next read.
  const Sample& read(const VehicleSnapshot& now, const Surroundings& around);
  /// Sets whether samples come over the link. If so, the code that transmits the sensor's pings must call take_question
  /// and answer.
  void use_link(bool has_modems);
  bool uses_link() const { return uses_link_; }
  /// Returns the number of the sample for which a ping was requested since the last call, if any.
  std::optional<std::uint64_t> take_question() { return std::exchange(question_, std::nullopt); }
  /// The longest time from ping to answer within the sensor's range [s].
  double longest_travel_time_s() const { return sensor_->longest_travel_time_s(); }
  /// Reports, at tick `now`, that the answer to a ping sent at `asked` has arrived, or that the ping has been
  /// abandoned.
  void answer(const VehicleSnapshot& asked, bool given_up, std::uint64_t now);

  /// Returns the present value without errors, rate, latency or drop-outs.
  const Sample& read_true(const VehicleSnapshot& now, const Surroundings& around);

  /// Starts collecting the samples that are measured at or after `from_ns`; nullopt stops collecting.
  void watch(std::optional<std::uint64_t> from_ns);
  /// The tick at whose start `collect` is due; kNever for a sensor that is not watched.
  std::uint64_t next_collection() const { return watch_ ? watch_->next_tick : kNever; }
  /// Collects the sample that has arrived by now, if it is new.
  void collect(const VehicleSnapshot& now, const Surroundings& around);
  /// Returns the samples collected since the last call. Throws InvalidValue for a sensor that is not watched.
  SampleBatch take_samples();
  void watch_like(const NoisySensor& other) { watch_ = other.watch_; }

  /// Saves or restores the history at `tick`; errors are a function of seed, names and time. Throws InvalidValue.
  void exchange_state(StateArchive& archive, std::uint64_t tick);
  /// See SampleHistory.
  void exchange_details(StateArchive& archive) { history_.exchange_details(archive, sample_.values.size()); }
  /// Computes the samples that have been recorded, before the parameters change on which they depend.
  void settle(const Surroundings& around);
  /// Takes over the samples of the same sensor with other parameters.
  void take_over(const NoisySensor& before) { history_.take_over(before.history_); }

 private:
  bool dropped(std::uint64_t tick) const;
  std::uint64_t arrival_ns(const VehicleSnapshot& measured, const Surroundings& around) const;
  void follow(const VehicleSnapshot& snapshot, const Surroundings& around, const SampleHistory::Entry* before,
              std::span<double> raw) const;
  void measure(const VehicleSnapshot& snapshot, const Surroundings& around, bool with_noise);
  void measure_recorded(const SampleHistory::Entry& entry, const Surroundings& around);
  void finish(const VehicleSnapshot& snapshot, bool with_noise);
  SensorInput input(const VehicleSnapshot& snapshot, const Surroundings& around) const;

  const SensorKind* kind_;
  SensorSpec spec_;
  std::unique_ptr<Sensor> sensor_;
  SampleClock clock_;
  Noise noise_;
  RandomStream drop_out_, memory_draws_;
  bool records_;  ///< false for a sensor that only measures the present
  bool uses_link_ = false;
  std::optional<std::uint64_t> question_;
  std::uint64_t next_due_;
  SampleHistory history_;
  std::vector<double> raw_;
  Sample sample_;
  std::uint64_t measured_tick_ = kNever;  ///< tick of the recorded snapshot from which sample_ was measured
  bool measured_valid_ = false;
  bool has_arrived_ = false;  ///< whether sample_ has arrived; if not, it is the present value
  std::optional<SampleWatch> watch_;
};

}  // namespace uwsim
