#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "uwsim/camera/kernels/block.h"

namespace uwsim {

/// The number of lanes that are set.
inline std::uint64_t count(const camera::BlockMask& mask) {
  return static_cast<std::uint64_t>(std::count(std::begin(mask.at), std::end(mask.at), -1));
}
inline bool any(const camera::BlockMask& mask) { return count(mask) > 0; }

}  // namespace uwsim
