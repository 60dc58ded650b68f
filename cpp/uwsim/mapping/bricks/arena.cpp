#include "uwsim/mapping/bricks/arena.h"

#include <algorithm>
#include <mutex>
#include <new>
#include <utility>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim::bricks {
namespace {

constexpr std::uint32_t kIndices = 1u << 31;
/// The number of bytes allocated before the first huge page, so that a small map uses little memory.
constexpr std::size_t kSmallBytes = 256 << 10;

/// Segments of destroyed arenas are kept, up to this much address space, because their pages are already present.
constexpr std::size_t kKeptBytes = 64 << 20;
struct KeptSegments {
  KeptSegments() { segments.reserve(kKeptBytes / kHugePage); }

  ForkSafeMutex<std::mutex> mutex;
  std::vector<MappedMemory> segments;
  std::size_t bytes = 0;
};

/// Never destroyed, since maps may outlive static objects.
KeptSegments& kept_segments() {
  static KeptSegments& kept = *new KeptSegments;
  return kept;
}

MappedMemory kept_segment(std::size_t bytes) {
  KeptSegments& kept = kept_segments();
  if (!kept.mutex.lock_unless_forked()) return {};
  const std::scoped_lock lock(std::adopt_lock, kept.mutex);
  for (MappedMemory& segment : kept.segments) {
    if (segment.size() != bytes) continue;
    MappedMemory found = std::move(segment);
    segment = std::move(kept.segments.back());
    kept.segments.pop_back();
    kept.bytes -= bytes;
    return found;
  }
  return {};
}

}  // namespace

Arena::Arena(std::size_t element_bytes, int segment_bits)
    : element_bytes_(element_bytes),
      segment_bits_(segment_bits),
      table_((kIndices >> segment_bits) * sizeof(std::byte*)) {}

Arena::~Arena() {
  KeptSegments& kept = kept_segments();
  if (!kept.mutex.lock_unless_forked()) return;
  const std::scoped_lock lock(std::adopt_lock, kept.mutex);
  for (MappedMemory& segment : segments_) {
    if (kept.bytes + segment.size() > kKeptBytes) continue;
    kept.bytes += segment.size();
    kept.segments.push_back(std::move(segment));
  }
}

std::uint32_t Arena::allocate(std::uint32_t count) {
  if (allocated_ > kIndices - count) throw std::bad_alloc();
  const std::size_t in_segment = std::size_t{1} << segment_bits_, end = std::size_t{allocated_} + count;
  while (segments_.size() * in_segment < end) {
    MappedMemory segment = kept_segment(in_segment * element_bytes_);
    if (segment.size() == 0) {
      segment = MappedMemory(in_segment * element_bytes_, segments_.empty() ? kSmallBytes : 0);
      segment.request_huge_pages();
    }
    table_.as<std::byte*>()[segments_.size()] = segment.as<std::byte>();
    segments_.push_back(std::move(segment));
  }
  for (std::size_t at = allocated_; at < end;) {
    const std::size_t within = at & (in_segment - 1), some = std::min(end - at, in_segment - within);
    segments_[at >> segment_bits_].prefault(within * element_bytes_, some * element_bytes_);
    at += some;
  }
  const std::uint32_t first = allocated_;
  allocated_ += count;
  return first;
}

std::size_t Arena::memory_bytes() const {
  const std::size_t bytes = allocated_ * element_bytes_;
  return bytes <= kSmallBytes ? bytes : (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

}  // namespace uwsim::bricks
