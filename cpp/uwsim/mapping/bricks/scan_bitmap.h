#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/mapping/bricks/mapped_memory.h"

namespace uwsim::bricks {

/// One scan's marks: a bit for each voxel of the box around the scan, by its address (address_layout.h). All bits are
/// zero between scans. Rays touch only a few of its pages. When a bitmap is destroyed, its memory is kept for later
/// ones, up to a few bitmaps, because those pages are already present.
class ScanBitmap {
 public:
  ScanBitmap() = default;
  ~ScanBitmap();
  ScanBitmap(ScanBitmap&& other) noexcept;
  ScanBitmap& operator=(ScanBitmap&& other) noexcept;

  /// Enlarges the bitmap for addresses of this many bits. Until end() is called, the bitmap counts as not zero.
  void begin(int address_bits);
  /// Must be called when the bitmap has been zeroed.
  void end() { is_in_use_ = false; }

  /// Voxels that rays passed through, one bit each
  std::uint64_t* missed() const { return missed_.as<std::uint64_t>(); }
  std::uint64_t* hit() const { return hit_.as<std::uint64_t>(); }        ///< voxels that contain points, one bit each
  std::uint8_t* touched() const { return touched_.as<std::uint8_t>(); }  ///< one byte per brick: 1 missed, 2 hit

 private:
  explicit ScanBitmap(int address_bits);

  MappedMemory missed_, hit_, touched_;
  bool is_in_use_ = false;
};

}  // namespace uwsim::bricks
