#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Arithmetic on voxel addresses (address_layout.h), one in each lane. Compiled into the scan_kernels_*.cpp that
/// include lanes_avx2.h or lanes_avx512.h before it.
namespace uwsim::bricks {
namespace {

/// Adds one to the bits of `mask`, as if they were adjacent.
Lanes add_one(Lanes address, Lanes mask) {
  return blend(mask, minus(with_others(address, mask), all_lanes(~0u)), address);
}

[[maybe_unused]] Lanes subtract_one(Lanes address, Lanes mask) {
  return blend(mask, plus(address & mask, all_lanes(~0u)), address);
}

}  // namespace
}  // namespace uwsim::bricks
