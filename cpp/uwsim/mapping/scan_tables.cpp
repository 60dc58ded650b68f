#include "uwsim/mapping/scan_tables.h"

#include <mutex>
#include <utility>
#include <vector>

namespace uwsim::bricks {
namespace {

constexpr std::size_t kKeptTables = 4;
/// Of addresses, a bit each: those of larger scans are not kept. What rays touch is a small part of it.
constexpr std::size_t kKeptBytes = std::size_t{32} << 20;

struct Kept {
  Kept() { tables.reserve(kKeptTables); }

  std::mutex mutex;
  std::vector<ScanTables> tables;
};

/// Never destroyed: maps may outlive what is.
Kept& kept() {
  static Kept& all = *new Kept;
  return all;
}

}  // namespace

ScanTables::ScanTables(int address_bits)
    : free_(std::size_t{1} << (address_bits - 3)),
      hit_(std::size_t{1} << (address_bits - 3)),
      touched_(std::size_t{1} << (address_bits - 9)) {}

ScanTables::~ScanTables() {
  if (is_in_use_ || free_.size() == 0 || free_.size() > kKeptBytes) return;
  Kept& all = kept();
  const std::scoped_lock lock(all.mutex);
  if (all.tables.size() < kKeptTables) all.tables.push_back(std::move(*this));
}

ScanTables::ScanTables(ScanTables&& other) noexcept { *this = std::move(other); }

ScanTables& ScanTables::operator=(ScanTables&& other) noexcept {
  std::swap(free_, other.free_);
  std::swap(hit_, other.hit_);
  std::swap(touched_, other.touched_);
  std::swap(is_in_use_, other.is_in_use_);
  return *this;
}

void ScanTables::begin(int address_bits) {
  const std::size_t bytes = std::size_t{1} << (address_bits - 3);
  if (free_.size() < bytes || is_in_use_) {
    ScanTables found;
    Kept& all = kept();
    {
      const std::scoped_lock lock(all.mutex);
      if (!all.tables.empty() && all.tables.back().free_.size() >= bytes) {
        found = std::move(all.tables.back());
        all.tables.pop_back();
      }
    }
    *this = found.free_.size() >= bytes ? std::move(found) : ScanTables(address_bits);
  }
  is_in_use_ = true;
}

}  // namespace uwsim::bricks
