#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

namespace uwsim {

/// A vector whose new elements are uninitialised: growing it does not write to memory that may never be used. For
/// trivial types only.
template <typename T>
class UninitialisedVector {
 public:
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  /// Makes room for `more` elements after the last one, and returns a pointer to them.
  T* reserve(std::size_t more) {
    if (size_ + more > capacity_) {
      const std::size_t capacity = std::max(size_ + more, capacity_ + capacity_ / 2);
      auto larger = std::make_unique_for_overwrite<T[]>(capacity);
      std::copy_n(data_.get(), size_, larger.get());
      data_ = std::move(larger);
      capacity_ = capacity;  // set last, since the allocation may throw
    }
    return data_.get() + size_;
  }
  /// Adds the first `by` reserved elements to the vector.
  void extend(std::size_t by) { size_ += by; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace uwsim
