#pragma once

#include <cstdint>

#include "uwsim/camera/kernels/block.h"

namespace uwsim {

/// The number of lanes that are set.
inline std::uint64_t count(const camera::BlockMask& mask) {
  std::int32_t set = 0;
  for (const std::int32_t lane : mask.at) set -= lane;
  return static_cast<std::uint64_t>(set);
}
inline bool any(const camera::BlockMask& mask) {
  std::int32_t found = 0;
  for (const std::int32_t lane : mask.at) found |= lane;
  return found != 0;
}

}  // namespace uwsim
