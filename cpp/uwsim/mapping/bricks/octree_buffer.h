#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "uwsim/mapping/atomic_file.h"

namespace uwsim {

/// The bytes of an octree while it is being written: they can be appended, overwritten in place, and removed from the
/// end. With a file, which may already have content, older bytes are written to the file and only the last few
/// megabytes stay in memory.
class OctreeBuffer {
 public:
  explicit OctreeBuffer(AtomicFile* file = nullptr) : file_(file), start_(file ? file->size() : 0) {}

  std::uint64_t size() const { return in_file_ + bytes_.size(); }

  void append(const char* bytes, std::size_t count) {
    if (file_ && bytes_.size() >= kKeptBytes) flush();
    bytes_.append(bytes, count);
  }

  /// Overwrites bytes that were appended in one call; such bytes are either all in memory or all in the file.
  void overwrite(std::uint64_t at, const char* bytes, std::size_t count) {
    if (at >= in_file_) {
      std::memcpy(bytes_.data() + (at - in_file_), bytes, count);
    } else {
      file_->overwrite(start_ + at, {bytes, count});
    }
  }

  void truncate(std::uint64_t size) {
    if (size >= in_file_) return bytes_.resize(size - in_file_);
    bytes_.clear();
    in_file_ = size;
    file_->truncate(start_ + size);
  }

  /// Writes the bytes that are still in memory to the file.
  void flush() {
    file_->append(bytes_);
    in_file_ += bytes_.size();
    bytes_.clear();
  }

  /// Returns all bytes and clears the buffer. Only valid without a file.
  std::string release() { return std::exchange(bytes_, {}); }

 private:
  static constexpr std::size_t kKeptBytes = std::size_t{4} << 20;

  AtomicFile* file_;
  std::uint64_t start_;  ///< where the octree begins in the file
  std::uint64_t in_file_ = 0;
  std::string bytes_;
};

}  // namespace uwsim
