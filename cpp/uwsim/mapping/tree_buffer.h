#pragma once

#include <cstring>
#include <string>
#include <utility>

#include "uwsim/mapping/atomic_file.h"

namespace uwsim {

/// Bytes of a tree in the making: appended, mended where they are, taken back from the end. With a file, which may hold
/// something already, the older ones go there, and only the last few megabytes stay in memory.
class TreeBuffer {
 public:
  explicit TreeBuffer(AtomicFile* file = nullptr) : file_(file), start_(file ? file->size() : 0) {}

  std::uint64_t size() const { return in_file_ + bytes_.size(); }

  void append(const char* bytes, std::size_t count) {
    if (file_ && bytes_.size() >= kKept) flush();
    bytes_.append(bytes, count);
  }

  void mend(std::uint64_t at, const char* bytes, std::size_t count) {
    // What is mended was appended in one go, so it lies on one side.
    if (at >= in_file_) {
      std::memcpy(bytes_.data() + (at - in_file_), bytes, count);
    } else {
      file_->overwrite(start_ + at, {bytes, count});
    }
  }

  void take_back(std::uint64_t to) {
    if (to >= in_file_) return bytes_.resize(to - in_file_);
    bytes_.clear();
    in_file_ = to;
    file_->truncate(start_ + to);
  }

  void flush() {
    file_->append(bytes_);
    in_file_ += bytes_.size();
    bytes_.clear();
  }

  /// What is in memory: all, without a file.
  std::string take() { return std::exchange(bytes_, {}); }

 private:
  static constexpr std::size_t kKept = std::size_t{4} << 20;

  AtomicFile* file_;
  std::uint64_t start_;
  std::uint64_t in_file_ = 0;
  std::string bytes_;
};

}  // namespace uwsim
