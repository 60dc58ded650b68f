#include "uwsim/mapping/pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

namespace uwsim {

Pages::Pages(std::size_t bytes, std::size_t small_bytes)
    : bytes_(bytes), mapping_bytes_(bytes + (bytes < kLargePage ? 0 : 2 * kLargePage)) {
  mapping_ =
      ::mmap(nullptr, mapping_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (mapping_ == MAP_FAILED) {
    mapping_ = nullptr;
    throw std::bad_alloc();
  }
  const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(mapping_);
  const std::uintptr_t aligned =
      mapping_bytes_ == bytes ? start : ((start + small_bytes + kLargePage - 1) & ~(kLargePage - 1)) - small_bytes;
  data_ = reinterpret_cast<void*>(aligned);
}

Pages::~Pages() {
  if (mapping_) ::munmap(mapping_, mapping_bytes_);
}

Pages::Pages(Pages&& other) noexcept { *this = std::move(other); }

Pages& Pages::operator=(Pages&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  std::swap(mapping_, other.mapping_);
  std::swap(mapping_bytes_, other.mapping_bytes_);
  return *this;
}

void Pages::ask_for_large() {
  const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(data_);
  const std::size_t whole = ((start + bytes_ + kLargePage - 1) & ~(kLargePage - 1)) - start;
  ::madvise(data_, bytes_ < kLargePage ? bytes_ : whole, MADV_HUGEPAGE);
}

void Pages::prefault([[maybe_unused]] std::size_t first_byte, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE
  constexpr std::size_t kPage = 4096;
  const std::size_t first = first_byte / kPage * kPage;
  const std::size_t end = std::min((first_byte + bytes + kPage - 1) / kPage * kPage, bytes_ / kPage * kPage);
  if (first < end) ::madvise(static_cast<std::byte*>(data_) + first, end - first, MADV_POPULATE_WRITE);
#endif
}

}  // namespace uwsim
