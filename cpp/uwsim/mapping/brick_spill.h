#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace uwsim::bricks {

/// A file without a name, gone with the process however it ends: room for what leaves memory.
class SpillFile {
 public:
  /// `folder`: where; empty for the system's own. Throws FileError.
  explicit SpillFile(const std::string& folder);
  ~SpillFile();
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;

  /// A place in it.
  struct Extent {
    std::uint64_t offset;
    std::uint32_t bytes;
    std::uint32_t room;  ///< a power of two
  };

  /// Throws FileError if the disk is full, and then nothing that was written before is lost.
  Extent write(std::span<const std::byte> bytes);
  void read(const Extent& extent, std::span<std::byte> bytes) const;
  /// Its room may be used again.
  void release(const Extent& extent);

  std::uint64_t size_bytes() const { return end_; }

 private:
  std::string folder_;
  int fd_;
  std::uint64_t end_ = 0;
  std::map<std::uint32_t, std::vector<std::uint64_t>> free_;  ///< offsets by room
};

/// Which chunks of a map are in memory, and how much of it they may take.
struct Residency {
  Residency(std::size_t limit, const std::string& folder) : limit_bytes(limit), file(folder) {}

  std::size_t limit_bytes;
  SpillFile file;
  std::unordered_map<std::uint32_t, SpillFile::Extent> saved;  ///< chunks the file has, in memory or not
  std::uint64_t now = 0;                                       ///< counts uses
  std::uint64_t evictions = 0;
  std::string trouble;  ///< why the file could not be written the last time
};

}  // namespace uwsim::bricks
