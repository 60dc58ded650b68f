#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>

#include "uwsim/core/check.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// Saves or restores vectors or matrices of known size, element by element.
template <typename... Values>
void exchange_numbers(StateArchive& archive, Values&&... values) {
  const auto exchange = [&](double* first, Eigen::Index n) { std::for_each(first, first + n, std::ref(archive)); };
  (exchange(values.data(), values.size()), ...);
}

/// Saves or restores a number that may be infinite or NaN.
inline void exchange_any(StateArchive& archive, double& value) {
  auto bits = std::bit_cast<std::uint64_t>(value);
  archive(bits);
  value = std::bit_cast<double>(bits);
}

/// Saves or restores values that must not be negative: standard deviations, variances or times.
template <typename... Values>
void exchange_not_negative(StateArchive& archive, Values&... values) {
  ((archive(values), require(values >= 0, "state.value", values, "must not be negative")), ...);
}

template <typename... Biases>
void exchange_bias(StateArchive& archive, Biases&... biases) {
  (exchange_not_negative(archive, biases.turn_on_std, biases.drift_std, biases.drift_time_s, biases.walk), ...);
}

}  // namespace uwsim
