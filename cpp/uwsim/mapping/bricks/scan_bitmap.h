#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/mapping/bricks/mapped_memory.h"

namespace uwsim::bricks {

/// The marks of one scan: one bit for each voxel of the box around the scan, indexed by the voxel's address
/// (address_layout.h). All bits are zero between scans. Rays touch only a few of the bitmap's pages. The memory of a
/// few destroyed bitmaps is kept for later bitmaps, because these pages are already present in it.
class ScanBitmap {
 public:
  ScanBitmap() = default;
  ~ScanBitmap();
  ScanBitmap(ScanBitmap&& other) noexcept;
  ScanBitmap& operator=(ScanBitmap&& other) noexcept;

  /// Enlarges the bitmap for addresses of this many bits. Until end() is called, the bitmap is assumed to contain
  /// marks.
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
