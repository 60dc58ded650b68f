#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

namespace uwsim {

/// An array that grows without writing to what is not used yet.
template <typename T>
class Growing {
 public:
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  /// Room for `more` elements after the last: where they go.
  T* room(std::size_t more) {
    if (size_ + more > capacity_) {
      const std::size_t capacity = std::max(size_ + more, capacity_ + capacity_ / 2);
      auto larger = std::make_unique_for_overwrite<T[]>(capacity);
      std::copy_n(data_.get(), size_, larger.get());
      data_ = std::move(larger);
      capacity_ = capacity;  // not before: there may be no memory
    }
    return data_.get() + size_;
  }
  void grow(std::size_t by) { size_ += by; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace uwsim
