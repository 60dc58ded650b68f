#include "uwsim/mapping/bricks/mapped_memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

namespace uwsim {

MappedMemory::MappedMemory(std::size_t bytes, std::size_t before_huge)
    : bytes_(bytes), mapping_bytes_(bytes + (bytes < kHugePage ? 0 : 2 * kHugePage)) {
  mapping_ =
      ::mmap(nullptr, mapping_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (mapping_ == MAP_FAILED) {
    mapping_ = nullptr;
    throw std::bad_alloc();
  }
  const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(mapping_);
  const std::uintptr_t aligned =
      mapping_bytes_ == bytes ? start : ((start + before_huge + kHugePage - 1) & ~(kHugePage - 1)) - before_huge;
  data_ = reinterpret_cast<void*>(aligned);
}

MappedMemory::~MappedMemory() {
  if (mapping_) ::munmap(mapping_, mapping_bytes_);
}

MappedMemory::MappedMemory(MappedMemory&& other) noexcept { *this = std::move(other); }

MappedMemory& MappedMemory::operator=(MappedMemory&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  std::swap(mapping_, other.mapping_);
  std::swap(mapping_bytes_, other.mapping_bytes_);
  return *this;
}

void MappedMemory::request_huge_pages() {
  const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(data_);
  const std::size_t whole = ((start + bytes_ + kHugePage - 1) & ~(kHugePage - 1)) - start;
  ::madvise(data_, bytes_ < kHugePage ? bytes_ : whole, MADV_HUGEPAGE);
}

void MappedMemory::prefault([[maybe_unused]] std::size_t first_byte, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE
  constexpr std::size_t kPage = 4096;
  const std::size_t first = first_byte / kPage * kPage;
  const std::size_t end = std::min((first_byte + bytes + kPage - 1) / kPage * kPage, bytes_ / kPage * kPage);
  if (first < end) ::madvise(static_cast<std::byte*>(data_) + first, end - first, MADV_POPULATE_WRITE);
#endif
}

}  // namespace uwsim
