#pragma once

#include <bit>
#include <cstdint>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// Saves or restores a vector or matrix of fixed size, element by element.
template <typename Values>
void exchange_numbers(StateArchive& archive, Values&& values) {
  for (Eigen::Index k = 0; k < values.size(); ++k) archive(values.data()[k]);
}

/// Saves or restores a number that may be infinite or NaN.
inline void exchange_any(StateArchive& archive, double& value) {
  auto bits = std::bit_cast<std::uint64_t>(value);
  archive(bits);
  value = std::bit_cast<double>(bits);
}

/// Saves or restores a value that must not be negative: a standard deviation, a variance or a time.
inline void exchange_not_negative(StateArchive& archive, double& value) {
  archive(value);
  require(value >= 0, "state.value", value, "must not be negative");
}

inline void exchange_bias(StateArchive& archive, BiasModel& bias) {
  for (double* value : {&bias.turn_on_std, &bias.drift_std, &bias.drift_time_s, &bias.walk}) {
    exchange_not_negative(archive, *value);
  }
}

}  // namespace uwsim
