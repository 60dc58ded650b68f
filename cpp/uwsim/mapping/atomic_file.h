#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace uwsim {

/// The whole of a regular file. Throws FileError naming the path and the system's reason.
std::string read_whole_file(const std::string& path);

/// A file that is written bit by bit to a temporary name beside the target, and takes its place when all is there:
/// whatever interrupts, the old file or the new one is there, never half of one. Until commit() a failure, or the end
/// of the object, leaves nothing behind. A link is followed; what exists and is no regular file (a folder, a device) is
/// refused. Throws FileError with the path and the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void append(std::string_view bytes);
  /// Bytes that are there already.
  void overwrite(std::uint64_t at, std::string_view bytes);
  /// Takes back all from there on.
  void truncate(std::uint64_t size);
  std::uint64_t size() const { return size_; }

  /// Flushes it to the disk and renames it.
  void commit();

 private:
  [[noreturn]] void fail(int error);

  std::string path_, target_, temporary_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

/// Writes to a temporary name beside the target, flushes it to the disk and renames it: whatever interrupts, the old
/// file or the new one is there, never half of one. On failure nothing is left behind and FileError names the path and
/// the system's reason. A link is followed; what exists and is no regular file (a folder, a device) is refused.
void write_file_atomically(const std::string& path, std::string_view bytes);

}  // namespace uwsim
