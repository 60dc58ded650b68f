#pragma once

#include "uwsim/core/double_lanes.h"
#include "uwsim/vehicle/pressure_kernels.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

void place(const VertexBlock* blocks, std::size_t count, const double* position_m, const double* rotation,
           double* points_m) {
  for (std::size_t n = 0; n < count; ++n) {
    const DoubleLanes x = load_lanes(blocks[n].arm_m[0]), y = load_lanes(blocks[n].arm_m[1]),
                      z = load_lanes(blocks[n].arm_m[2]);
    const auto row = [&](std::size_t k) {
      return position_m[k] + (rotation[3 * k] * x + rotation[3 * k + 1] * y + rotation[3 * k + 2] * z);
    };
    store_points(row(0), row(1), row(2), points_m + 3 * kPressureLanes * n);
  }
}

void pressures(const double* heads_m, std::size_t block_count, double pascal_per_m, double* pressures_pa) {
  for (std::size_t n = 0; n < block_count * kPressureLanes; n += kPressureLanes) {
    const DoubleLanes head = load_lanes(heads_m + n);
    store_lanes(head > 0 ? head * pascal_per_m : DoubleLanes{}, pressures_pa + n);
  }
}

void find_wet(const double* heads_m, std::size_t block_count, std::uint8_t* wet) {
  for (std::size_t n = 0; n < block_count * kPressureLanes; n += kPressureLanes) {
    store_flags(load_lanes(heads_m + n) > 0, wet + n);
  }
}

void load(const VertexBlock* blocks, std::size_t count, const double* pressures_pa, double* load) {
  DoubleLanes sums[6] = {};
  for (std::size_t n = 0; n < count; ++n) {
    const DoubleLanes pressure = load_lanes(pressures_pa + kPressureLanes * n);
    for (std::size_t k = 0; k < 6; ++k) sums[k] += pressure * load_lanes(blocks[n].per_pascal[k]);
  }
  for (std::size_t k = 0; k < 6; ++k) load[k] = sum_of_lanes(sums[k]);
}

constexpr PressureKernels kKernels = {place, pressures, find_wet, load};

}  // namespace
}  // namespace uwsim
