#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace uwsim {

/// Memory for images. Some released memory is kept for the next picture, because the operating system clears every page
/// that it provides. Throws std::bad_alloc.
void* acquire_buffer(std::size_t bytes);
void release_buffer(void* memory, std::size_t bytes) noexcept;

/// An allocator that leaves new elements uninitialised, since every pixel is written anyway.
template <typename T>
struct ImageBufferAllocator {
  using value_type = T;

  ImageBufferAllocator() = default;
  template <typename U>
  ImageBufferAllocator(const ImageBufferAllocator<U>&) noexcept {
  }  // NOLINT(google-explicit-constructor): as std::allocator

  T* allocate(std::size_t count) { return static_cast<T*>(acquire_buffer(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t count) noexcept { release_buffer(memory, count * sizeof(T)); }

  template <typename U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <typename U, typename... Values>
  void construct(U* at, Values&&... values) {
    ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }

  bool operator==(const ImageBufferAllocator&) const { return true; }
};

/// The values of an image; resize() leaves new ones uninitialised.
template <typename T>
using ImageBuffer = std::vector<T, ImageBufferAllocator<T>>;

}  // namespace uwsim
