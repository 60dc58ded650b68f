#pragma once

#include <cstddef>

namespace uwsim {

inline constexpr std::size_t kLargePage = std::size_t{1} << 21;

/// Memory of the system's own, all zero, of which only what is touched takes room. Throws std::bad_alloc.
class Pages {
 public:
  Pages() = default;
  /// Of what is as large, the first large page begins after `small_bytes`.
  explicit Pages(std::size_t bytes, std::size_t small_bytes = 0);
  ~Pages();
  Pages(Pages&& other) noexcept;
  Pages& operator=(Pages&& other) noexcept;

  /// Asks for large pages, where they fit.
  void ask_for_large();
  /// Has the pages of a part present: no page faults there later. What the system cannot do is left.
  void prefault(std::size_t first_byte, std::size_t bytes);

  std::size_t size() const { return bytes_; }
  template <typename T>
  T* as() const {
    return static_cast<T*>(data_);
  }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
  void* mapping_ = nullptr;  ///< larger than what is used, to start where a large page does
  std::size_t mapping_bytes_ = 0;
};

}  // namespace uwsim
