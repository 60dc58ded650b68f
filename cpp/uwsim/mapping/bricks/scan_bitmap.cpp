#include "uwsim/mapping/bricks/scan_bitmap.h"

#include <mutex>
#include <utility>
#include <vector>

#include "uwsim/core/fork_safe_mutex.h"

namespace uwsim::bricks {
namespace {

constexpr std::size_t kKeptBitmaps = 4;
/// Larger tables are not kept. The limit applies to address space, of which rays touch only a small part.
constexpr std::size_t kKeptBitmapBytes = std::size_t{32} << 20;

struct KeptBitmaps {
  KeptBitmaps() { bitmaps.reserve(kKeptBitmaps); }

  ForkSafeMutex<std::mutex> mutex;
  std::vector<ScanBitmap> bitmaps;
};

/// Never destroyed, since maps may outlive static objects.
KeptBitmaps& kept_bitmaps() {
  static KeptBitmaps& kept = *new KeptBitmaps;
  return kept;
}

}  // namespace

ScanBitmap::ScanBitmap(int address_bits)
    : missed_(std::size_t{1} << (address_bits - 3)),
      hit_(std::size_t{1} << (address_bits - 3)),
      touched_(std::size_t{1} << (address_bits - 9)) {}

ScanBitmap::~ScanBitmap() {
  if (is_in_use_ || missed_.size() == 0 || missed_.size() > kKeptBitmapBytes) return;
  KeptBitmaps& kept = kept_bitmaps();
  if (!kept.mutex.lock_unless_forked()) return;
  const std::scoped_lock lock(std::adopt_lock, kept.mutex);
  if (kept.bitmaps.size() < kKeptBitmaps) kept.bitmaps.push_back(std::move(*this));
}

ScanBitmap::ScanBitmap(ScanBitmap&& other) noexcept { *this = std::move(other); }

ScanBitmap& ScanBitmap::operator=(ScanBitmap&& other) noexcept {
  std::swap(missed_, other.missed_);
  std::swap(hit_, other.hit_);
  std::swap(touched_, other.touched_);
  std::swap(is_in_use_, other.is_in_use_);
  return *this;
}

void ScanBitmap::begin(int address_bits) {
  const std::size_t bytes = std::size_t{1} << (address_bits - 3);
  if (missed_.size() < bytes || is_in_use_) {
    ScanBitmap found;
    KeptBitmaps& kept = kept_bitmaps();
    if (kept.mutex.lock_unless_forked()) {
      const std::scoped_lock lock(std::adopt_lock, kept.mutex);
      if (!kept.bitmaps.empty() && kept.bitmaps.back().missed_.size() >= bytes) {
        found = std::move(kept.bitmaps.back());
        kept.bitmaps.pop_back();
      }
    }
    *this = found.missed_.size() >= bytes ? std::move(found) : ScanBitmap(address_bits);
  }
  is_in_use_ = true;
}

}  // namespace uwsim::bricks
