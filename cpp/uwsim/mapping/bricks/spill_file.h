#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace uwsim::bricks {

/// An unnamed file for data that is evicted from memory. It disappears with the process, even after a crash.
class SpillFile {
 public:
  /// `folder`: where the file is created; empty for the system's folder for temporary files. Throws FileError.
  explicit SpillFile(const std::string& folder);
  ~SpillFile();
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;

  /// A region of the file.
  struct Extent {
    std::uint64_t offset;
    std::uint32_t bytes;
    std::uint32_t reserved;  ///< a power of two, at least `bytes`
  };

  /// Throws FileError if the disk is full; data written earlier remains valid.
  Extent write(std::span<const std::byte> bytes);
  void read(const Extent& extent, std::span<std::byte> bytes) const;
  /// Makes the region available for later writes.
  void release(const Extent& extent);

 private:
  std::string folder_;
  int fd_;
  std::uint64_t end_ = 0;
  std::map<std::uint32_t, std::vector<std::uint64_t>> free_;  ///< offsets of released regions, by their reserved size
};

}  // namespace uwsim::bricks
