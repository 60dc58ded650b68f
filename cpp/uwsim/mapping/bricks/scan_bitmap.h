#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/mapping/bricks/mapped_memory.h"

namespace uwsim::bricks {

/// One scan's marks: a bit for each voxel of the box around the scan, by its address (address_layout.h). All zero
/// between scans. Rays touch few pages of it. When a bitmap is destroyed its memory is kept for the next ones, a few of
/// them, because those pages are present already.
class ScanBitmap {
 public:
  ScanBitmap() = default;
  ~ScanBitmap();
  ScanBitmap(ScanBitmap&& other) noexcept;
  ScanBitmap& operator=(ScanBitmap&& other) noexcept;

  /// Makes it large enough for addresses of so many bits. Until end() is called the bitmap counts as not zero.
  void begin(int address_bits);
  /// The caller has zeroed the bitmap.
  void end() { is_in_use_ = false; }

  std::uint64_t* missed() const { return missed_.as<std::uint64_t>(); }  ///< voxels that rays passed, one bit each
  std::uint64_t* hit() const { return hit_.as<std::uint64_t>(); }        ///< voxels that hold points, one bit each
  std::uint8_t* touched() const { return touched_.as<std::uint8_t>(); }  ///< one byte a brick: 1 missed, 2 hit

 private:
  explicit ScanBitmap(int address_bits);

  MappedMemory missed_, hit_, touched_;
  bool is_in_use_ = false;
};

}  // namespace uwsim::bricks
