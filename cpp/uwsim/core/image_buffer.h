#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace uwsim {

/// Memory for images. Some released memory is kept for the next picture, because the operating system clears every page
/// that it provides. Throws std::bad_alloc.
void* acquire_buffer(std::size_t bytes);
void release_buffer(void* memory, std::size_t bytes) noexcept;

/// The values of an image. A vector would take time to destroy them one by one, though there is nothing to do.
template <typename T>
class ImageBuffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  using value_type = T;

  ImageBuffer() = default;
  explicit ImageBuffer(std::size_t count) { resize(count); }
  ImageBuffer(ImageBuffer&& other) noexcept { swap(other); }
  ImageBuffer& operator=(ImageBuffer&& other) noexcept {
    ImageBuffer(std::move(other)).swap(*this);
    return *this;
  }
  ~ImageBuffer() {
    if (values_ != nullptr) release_buffer(values_, size_ * sizeof(T));
  }

  /// Leaves the values uninitialised, since every pixel is written anyway; those of another size are lost.
  void resize(std::size_t count) {
    if (count == size_) return;
    ImageBuffer other;
    if (count > 0) other.values_ = static_cast<T*>(acquire_buffer(count * sizeof(T)));
    other.size_ = count;
    swap(other);
  }
  void assign(std::size_t count, const T& value) {
    resize(count);
    std::fill_n(values_, count, value);
  }
  void swap(ImageBuffer& other) noexcept {
    std::swap(values_, other.values_);
    std::swap(size_, other.size_);
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return values_; }
  const T* data() const { return values_; }
  T* begin() { return values_; }
  T* end() { return values_ + size_; }
  const T* begin() const { return values_; }
  const T* end() const { return values_ + size_; }
  T& operator[](std::size_t k) { return values_[k]; }
  const T& operator[](std::size_t k) const { return values_[k]; }

  bool operator==(const ImageBuffer& other) const { return std::equal(begin(), end(), other.begin(), other.end()); }

 private:
  T* values_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace uwsim
