#include "uwsim/sensors/noisy_sensor.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/sensors/sensor_kinds.h"

namespace uwsim {
namespace {

constexpr double kMaxHeldSamples = 1e5;

/// Whether the time of a sample may differ from the time at which it is read.
bool has_history(const SensorSpec& spec, const Sensor& sensor, const SampleClock& clock) {
  return sensor.remembers() || !clock.every_step() || spec.latency_s > 0 || spec.drop_out > 0 ||
         sensor.longest_travel_time_s() > 0;
}

/// The number of samples that may be in transit, plus one for the sample that has arrived and one to allow for
/// rounding.
std::size_t held_samples(const SensorSpec& spec, const Sensor& sensor, const SampleClock& clock) {
  const double held = (spec.latency_s + sensor.longest_travel_time_s()) / clock.period_s() + 3;
  require(held <= kMaxHeldSamples, "sensors." + spec.name + ".latency_s", spec.latency_s,
          "must be at most 100000 sample periods");
  return static_cast<std::size_t>(held);
}

}  // namespace

NoisySensor::NoisySensor(const SensorSpec& spec, std::uint64_t seed, std::string_view vehicle, std::uint64_t step_ns)
    : kind_(&sensor_kind(spec.kind, "sensors." + spec.name + ".kind")),
      spec_(completed(spec, *kind_)),
      sensor_(kind_->make(spec_)),
      clock_(spec.rate_hz, step_ns),
      noise_(*kind_, spec_, seed, stream_name(vehicle, spec.name), clock_.period_s()),
      drop_out_(seed, stream_name(vehicle, spec.name, "drop_out")),
      memory_draws_(seed, stream_name(vehicle, spec.name, "memory")),
      records_(has_history(spec_, *sensor_, clock_)),
      next_due_(records_ ? 0 : kNever),
      history_(held_samples(spec_, *sensor_, clock_),
               sensor_->rays({}) || sensor_->remembers() ? kind_->raw_width() : 0),
      raw_(kind_->raw_width()) {
  sample_.values.resize(kind_->reading_width());
}

void NoisySensor::record(const VehicleSnapshot& snapshot, const Surroundings& around) {
  if (uses_link_) {
    question_ = clock_.sample_at(snapshot.tick);
  } else if (clock_.samples_at(snapshot.tick)) {
    const SampleHistory::Entry* before = history_.newest();
    SampleHistory::Entry& entry = history_.push(snapshot, dropped(snapshot.tick));
    const std::optional<RayCone> rays = sensor_->rays(snapshot.state.world_from_body);
    entry.observed = sensor_->remembers() || (rays && around.scene.bodies_in(*rays));
    if (entry.observed) {
      sensor_->observe(input(snapshot, around), entry.raw);
      follow(snapshot, around, before, entry.raw);
    }
  }
  next_due_ = clock_.tick_of(clock_.sample_at(snapshot.tick) + 1);
}

bool NoisySensor::dropped(std::uint64_t tick) const {
  return spec_.drop_out > 0 && drop_out_.uniform(clock_.sample_at(tick)) < spec_.drop_out;
}

SensorInput NoisySensor::input(const VehicleSnapshot& snapshot, const Surroundings& around) const {
  return {snapshot, around, 1e-9 * static_cast<double>(clock_.time_ns(snapshot.tick))};
}

std::uint64_t NoisySensor::arrival_ns(const VehicleSnapshot& measured, const Surroundings& around) const {
  if (uses_link_) return 0;  // a sample that has not arrived is not yet in the history
  const double delay_s = spec_.latency_s + sensor_->travel_time_s(input(measured, around));
  return clock_.time_ns(measured.tick) + static_cast<std::uint64_t>(std::llround(delay_s * 1e9));
}

void NoisySensor::follow(const VehicleSnapshot& snapshot, const Surroundings& around,
                         const SampleHistory::Entry* before, std::span<double> raw) const {
  if (!sensor_->remembers()) return;
  const std::uint64_t then = before ? before->snapshot.tick : snapshot.tick;
  const double elapsed_s = 1e-9 * static_cast<double>(clock_.time_ns(snapshot.tick) - clock_.time_ns(then));
  const std::span<const double> values = before ? std::span<const double>(before->raw) : std::span<const double>();
  sensor_->follow(input(snapshot, around), {values, elapsed_s, memory_draws_, clock_.sample_at(snapshot.tick)}, raw);
}

void NoisySensor::measure(const VehicleSnapshot& snapshot, const Surroundings& around, bool with_noise) {
  const SampleHistory::Entry* newest = history_.newest();
  if (with_noise && sensor_->remembers() && newest && newest->snapshot.tick == snapshot.tick) {
    raw_ = newest->raw;
  } else {
    sensor_->observe(input(snapshot, around), raw_);
    if (with_noise) follow(snapshot, around, newest, raw_);
  }
  finish(snapshot, with_noise);
}

void NoisySensor::measure_recorded(const SampleHistory::Entry& entry, const Surroundings& around) {
  if (entry.settled) {
    std::copy(entry.reading.begin(), entry.reading.end(), sample_.values.begin());
    sample_.stamp_ns = clock_.time_ns(entry.snapshot.tick);
    sample_.valid = measured_valid_ = entry.valid;
    return;
  }
  if (entry.observed) {
    raw_ = entry.raw;
  } else {  // no ray could hit a body; plants lean as they did
    Surroundings then{around.scene.with(nullptr), around.water, around.sound, around.world};
    const SensorInput measured = input(entry.snapshot, then);
    if (then.scene.sways()) then.scene = then.scene.with_plants(Sway::of(*then.world, measured.time_s));
    sensor_->observe(measured, raw_);
  }
  finish(entry.snapshot, true);
}

void NoisySensor::settle(const Surroundings& around) {
  history_.visit_all([&](SampleHistory::Entry& entry) {
    if (entry.settled) return;
    measure_recorded(entry, around);
    entry.reading = sample_.values;
    entry.valid = measured_valid_;
    entry.arrival_ns = arrival_ns(entry.snapshot, around);
    entry.settled = true;
  });
  measured_tick_ = kNever;  // sample_ is the last of them
}

void NoisySensor::finish(const VehicleSnapshot& snapshot, bool with_noise) {
  if (with_noise) {
    sensor_->distort(raw_);
    noise_.apply(clock_.sample_at(snapshot.tick), raw_);
  }
  measured_valid_ = sensor_->report(raw_, sample_.values);
  sample_.stamp_ns = clock_.time_ns(snapshot.tick);
  sample_.valid = measured_valid_;
  measured_tick_ = kNever;
}

void NoisySensor::exchange_state(StateArchive& archive, std::uint64_t tick) {
  archive.same("sensor", spec_.name);
  archive.same("sensor kind", std::string(kind_->name));
  history_.exchange_state(archive, tick);
  if (!archive.restoring()) return;
  measured_tick_ = kNever;  // sample_ belongs to a different time
  if (records_) next_due_ = clock_.samples_at(tick) ? tick : clock_.tick_of(clock_.sample_at(tick) + 1);
}

const Sample& NoisySensor::read_true(const VehicleSnapshot& now, const Surroundings& around) {
  measure(now, around, false);
  return sample_;
}

const Sample& NoisySensor::read(const VehicleSnapshot& now, const Surroundings& around) {
  bool newest_dropped = false, found = false;
  // Whether this measurement can be used as the sample: it has arrived and was not dropped.
  const auto gives_sample = [&](std::uint64_t arrived_ns, bool is_dropped) {
    if (arrived_ns > clock_.time_ns(now.tick)) return false;
    newest_dropped |= is_dropped;
    return found = !is_dropped;
  };
  if (!uses_link_ && clock_.samples_at(now.tick) && gives_sample(arrival_ns(now, around), dropped(now.tick))) {
    measure(now, around, true);
  } else {
    history_.visit_back([&](const SampleHistory::Entry& entry) {
      const std::uint64_t arrived_ns = entry.settled ? entry.arrival_ns : arrival_ns(entry.snapshot, around);
      if (!gives_sample(arrived_ns, entry.dropped)) return false;
      if (measured_tick_ != entry.snapshot.tick) measure_recorded(entry, around);
      measured_tick_ = entry.snapshot.tick;
      return true;
    });
  }
  if (found) sample_.valid = measured_valid_ && !newest_dropped;
  if (!found) {
    measure(now, around, true);
    sample_.valid = false;
  }
  has_arrived_ = found;
  return sample_;
}

void NoisySensor::use_link(bool has_modems) {
  uses_link_ = has_modems && sensor_->shares_modem();
  question_.reset();
}

void NoisySensor::answer(const VehicleSnapshot& asked, bool given_up, std::uint64_t now) {
  history_.push(asked, given_up || dropped(asked.tick));
  if (watch_) watch_->next_tick = now;
}

void NoisySensor::watch(std::optional<std::uint64_t> from_ns) {
  if (!from_ns) return watch_.reset();
  watch_.emplace().from_ns = *from_ns;
}

void NoisySensor::collect(const VehicleSnapshot& now, const Surroundings& around) {
  if (now.tick < next_collection()) return;
  read(now, around);
  if (has_arrived_ && sample_.stamp_ns >= watch_->from_ns) {
    watch_->add(sample_.stamp_ns, clock_.time_ns(now.tick), sample_.values, measured_valid_);
  }
  if (uses_link_) {
    watch_->next_tick = kNever;  // nothing to collect until an answer arrives
    return;
  }
  const std::uint64_t newest = clock_.sample_at(now.tick), measured = clock_.tick_of(newest);
  const bool in_transit = clock_.time_ns(measured) >= watch_->from_ns && !dropped(measured);
  watch_->next_tick = in_transit ? now.tick + 1 : clock_.tick_of(newest + 1);
}

SampleBatch NoisySensor::take_samples() {
  require(watch_.has_value(), "sensor", spec_.name, "must be watched");
  return std::exchange(watch_->arrived, {});
}

}  // namespace uwsim
