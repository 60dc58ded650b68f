#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace uwsim {

/// Memory for pictures' planes; some of what is given back is kept for the next picture, since the system clears every
/// page that it hands out. Throws std::bad_alloc.
void* take_plane(std::size_t bytes);
void give_plane_back(void* memory, std::size_t bytes) noexcept;

/// Leaves what nobody has written yet as it is, since every pixel is written anyway.
template <typename T>
struct PlaneAllocator {
  using value_type = T;

  PlaneAllocator() = default;
  template <typename U>
  PlaneAllocator(const PlaneAllocator<U>&) noexcept {}  // NOLINT(google-explicit-constructor): as the standard's

  T* allocate(std::size_t count) { return static_cast<T*>(take_plane(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t count) noexcept { give_plane_back(memory, count * sizeof(T)); }

  template <typename U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <typename U, typename... Values>
  void construct(U* at, Values&&... values) {
    ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }

  bool operator==(const PlaneAllocator&) const { return true; }
};

/// A picture's values, which resize() does not set.
template <typename T>
using Plane = std::vector<T, PlaneAllocator<T>>;

}  // namespace uwsim
