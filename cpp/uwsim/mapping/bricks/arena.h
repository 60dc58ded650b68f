#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwsim/mapping/bricks/mapped_memory.h"

namespace uwsim::bricks {

/// Storage for elements of one size, identified by index. Elements never move, and new elements are uninitialised. Only
/// one thread at a time may allocate; any number of threads may look elements up. When an arena is destroyed, some of
/// its memory is kept for the next arena.
class Arena {
 public:
  /// Segments contain 2^segment_bits elements each.
  Arena(std::size_t element_bytes, int segment_bits);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Returns the index of the first of `count` new elements. Throws std::bad_alloc.
  std::uint32_t allocate(std::uint32_t count);
  std::byte* at(std::uint32_t index) const {
    return segments()[index >> segment_bits_] + element_bytes_ * (index & ((1u << segment_bits_) - 1));
  }
  std::uint32_t allocated() const { return allocated_; }
  std::byte* const* segments() const { return table_.as<std::byte*>(); }
  std::size_t memory_bytes() const;

 private:
  std::size_t element_bytes_;
  int segment_bits_;
  std::uint32_t allocated_ = 0;
  MappedMemory table_;  ///< addresses of the segments; reserved at full size, so that it never moves
  std::vector<MappedMemory> segments_;
};

}  // namespace uwsim::bricks
