#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/mapping/pages.h"

namespace uwsim::bricks {

/// The scratch tables of a scan, all zero between scans. Those of tracers that are gone are kept for the next ones, a
/// few of them: their pages, which rays have touched here and there, are present already.
class ScanTables {
 public:
  ScanTables() = default;
  ~ScanTables();
  ScanTables(ScanTables&& other) noexcept;
  ScanTables& operator=(ScanTables&& other) noexcept;

  /// Room for voxels with addresses of so many bits. Until end() the tables are not all zero.
  void begin(int address_bits);
  void end() { is_in_use_ = false; }

  std::uint64_t* free() const { return free_.as<std::uint64_t>(); }      ///< a bit a voxel
  std::uint64_t* hit() const { return hit_.as<std::uint64_t>(); }        ///< the same
  std::uint8_t* touched() const { return touched_.as<std::uint8_t>(); }  ///< a byte a brick of 512 voxels

 private:
  explicit ScanTables(int address_bits);

  Pages free_, hit_, touched_;
  bool is_in_use_ = false;
};

}  // namespace uwsim::bricks
