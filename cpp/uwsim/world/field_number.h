#pragma once

#include <atomic>
#include <cstdint>

namespace uwsim {

/// A number that no other field of this process has, by which threads remember parts of it; never 0.
inline std::uint64_t next_field_number() {
  static std::atomic<std::uint64_t> made{0};
  return ++made;
}

}  // namespace uwsim
