#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace uwsim {

/// Samples in order of arrival. values: one row per sample, as wide as a reading.
struct SampleBatch {
  std::vector<std::uint64_t> stamps_ns, arrivals_ns;
  std::vector<double> values;
  std::vector<std::uint8_t> valid;
};

/// The state of a watched sensor: each sample that was not dropped is delivered once, when it arrives.
struct SampleWatch {
  std::uint64_t from_ns = 0;    ///< samples with earlier stamps are ignored
  std::uint64_t next_tick = 0;  ///< earliest tick at which a sample may arrive
  SampleBatch arrived;

  void add(std::uint64_t stamp_ns, std::uint64_t arrival_ns, std::span<const double> values, bool valid) {
    arrived.stamps_ns.push_back(stamp_ns);
    arrived.arrivals_ns.push_back(arrival_ns);
    arrived.values.insert(arrived.values.end(), values.begin(), values.end());
    arrived.valid.push_back(valid);
    from_ns = stamp_ns + 1;
  }
};

}  // namespace uwsim
