#pragma once

#include <cstddef>

namespace uwsim {

inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Zeroed memory obtained directly from the operating system. A page takes up memory only once it has been written to.
class MappedMemory {
 public:
  MappedMemory() = default;
  /// If the memory spans at least one huge page, it is aligned so that the first huge page begins `before_huge` bytes
  /// after its start. Throws std::bad_alloc.
  explicit MappedMemory(std::size_t bytes, std::size_t before_huge = 0);
  ~MappedMemory();
  MappedMemory(MappedMemory&& other) noexcept;
  MappedMemory& operator=(MappedMemory&& other) noexcept;

  /// Requests huge pages from the system where possible.
  void request_huge_pages();
  /// Commits the pages of a range now, so that writing to them causes no page faults. This is a hint: failures are
  /// ignored.
  void prefault(std::size_t first_byte, std::size_t bytes);

  std::size_t size() const { return bytes_; }
  template <typename T>
  T* as() const {
    return static_cast<T*>(data_);
  }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
  void* mapping_ = nullptr;  ///< contains data_; larger, to allow for alignment
  std::size_t mapping_bytes_ = 0;
};

}  // namespace uwsim
