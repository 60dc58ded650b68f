#include "uwsim/mapping/bricks/scan_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

constexpr std::size_t kLanes = 32;  // largest number of rays that a kernel walks at a time

}  // namespace

void ScanTrace::clear() {
  chunks.clear();
  entries.clear();
  masks.clear();
}

void ScanTracer::trace(const ScanInput& scan, ScanTrace& trace) {
  trace.clear();
  wide_.clear();  // not empty if the previous scan ran out of memory
  if (scan.count == 0) return;
  reserve(scan.count);
  kernels_.start_rays(scan, rays_);
  Key origin{};
  const double factor = 1.0 / scan.resolution_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    origin[axis] = static_cast<std::uint32_t>(static_cast<int>(std::floor(factor * scan.origin_m[axis])) + 32768);
  }
  const AddressLayout layout(origin, rays_.end_key, scan.count);
  if (layout.fits_table) bitmap_.begin(layout.bits);
  find_addresses(scan.count, layout);
  sort_walks(scan.count);
  walk(layout, layout.address(origin));
  mark_hits(scan.count, layout);
  if (!layout.fits_table) return collect_wide(trace);
  collect(layout, trace);
  bitmap_.end();
}

void ScanTracer::reserve(std::size_t rays) {
  if (rays <= capacity_) return;
  capacity_ = 0;  // 0 until all vectors have grown, since an allocation may throw
  columns_.resize(7 * rays);
  keys_.resize(3 * rays);
  bytes_.resize(2 * rays);
  steps_.resize(rays);
  order_.resize(rays + kLanes);
  address_.resize(rays);
  end_address_.resize(rays);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rays_.next[axis] = columns_.data() + axis * rays;
    rays_.stride[axis] = columns_.data() + (3 + axis) * rays;
    rays_.end_key[axis] = keys_.data() + axis * rays;
  }
  rays_.length = columns_.data() + 6 * rays;
  rays_.steps = steps_.data();
  rays_.negative = bytes_.data();
  rays_.kind = bytes_.data() + rays;
  capacity_ = rays;
}

void ScanTracer::find_addresses(std::size_t count, const AddressLayout& layout) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t address = layout.address({rays_.end_key[0][i], rays_.end_key[1][i], rays_.end_key[2][i]});
    std::uint64_t mirror = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (rays_.negative[i] >> axis & 1) mirror |= layout.axis_mask[axis];
    }
    address_[i] = address;
    end_address_[i] = address ^ mirror;
  }
}

/// Sorts the rays to walk by number of steps, so that rays that are walked together also end at about the same time.
void ScanTracer::sort_walks(std::size_t count) {
  constexpr std::size_t kBuckets = 1024;
  std::array<std::uint32_t, kBuckets + 1> starts{};
  const std::uint32_t longest = *std::max_element(steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(count));
  const int shift = std::max(0, static_cast<int>(std::bit_width(longest)) - 10);
  for (std::size_t i = 0; i < count; ++i) {
    if (steps_[i] != 0) ++starts[(steps_[i] >> shift) + 1];
  }
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) starts[bucket + 1] += starts[bucket];
  order_.resize(starts[kBuckets] + kLanes);
  for (std::size_t i = 0; i < count; ++i) {
    if (steps_[i] != 0) order_[starts[steps_[i] >> shift]++] = static_cast<std::uint32_t>(i);
  }
  const std::size_t walks = order_.size() - kLanes;
  if (walks > 0) std::fill(order_.begin() + static_cast<std::ptrdiff_t>(walks), order_.end(), order_[walks - 1]);
}

void ScanTracer::walk(const AddressLayout& layout, std::uint64_t origin_address) {
  WalkInput input{};
  input.rays = &rays_;
  input.order = order_.data();
  input.count = order_.size() - kLanes;
  input.end_address = end_address_.data();
  input.origin_address = origin_address;
  std::copy_n(layout.axis_mask.begin(), 3, input.axis_mask);
  if (layout.fits_table) {
    input.table = bitmap_.missed();
    input.touched = bitmap_.touched();
  } else {
    input.context = &wide_;
    input.mark = [](void* context, std::uint64_t word, std::uint64_t mask) {
      (*static_cast<decltype(wide_)*>(context))[word >> 3].missed[word & 7] |= mask;
    };
  }
  kernels_.walk(input);
}

void ScanTracer::mark_hits(std::size_t count, const AddressLayout& layout) {
  std::uint64_t* const hit = bitmap_.hit();
  std::uint8_t* const touched = bitmap_.touched();
  for (std::size_t i = 0; i < count; ++i) {
    if (rays_.kind[i] != kHit) continue;
    const std::uint64_t address = address_[i], bit = std::uint64_t{1} << (address & 63);
    if (layout.fits_table) {
      hit[address >> 6] |= bit;
      touched[address >> 9] |= 2;
    } else {
      wide_[address >> 9].hit[address >> 6 & 7] |= bit;
    }
  }
}

void ScanTracer::collect(const AddressLayout& layout, ScanTrace& trace) {
  for (std::uint32_t z = 0; z < layout.chunks[2]; ++z) {
    for (std::uint32_t y = 0; y < layout.chunks[1]; ++y) {
      for (std::uint32_t x = 0; x < layout.chunks[0]; ++x) {
        const std::size_t chunk = layout.chunk_address(x, y, z) >> AddressLayout::kChunkBits;
        const Collected found =
            kernels_.collect({bitmap_.missed() + 4096 * chunk, bitmap_.hit() + 4096 * chunk,
                              bitmap_.touched() + 512 * chunk, trace.entries.reserve(512), trace.masks.reserve(8200)});
        if (found.entries == 0) continue;
        const std::uint64_t code =
            morton::code(layout.first_chunk[0] + x, layout.first_chunk[1] + y, layout.first_chunk[2] + z);
        trace.chunks.push_back({static_cast<std::uint32_t>(code), static_cast<std::uint32_t>(trace.entries.size()),
                                static_cast<std::uint32_t>(found.entries), trace.masks.size()});
        trace.entries.extend(found.entries);
        trace.masks.extend(found.masks);
      }
    }
  }
}

void ScanTracer::collect_wide(ScanTrace& trace) {
  std::vector<std::uint64_t> codes;
  codes.reserve(wide_.size());
  for (const auto& [code, brick] : wide_) codes.push_back(code);
  std::sort(codes.begin(), codes.end());
  for (const std::uint64_t code : codes) {
    const WideBrick& brick = wide_.at(code);
    const auto chunk = static_cast<std::uint32_t>(code >> 9);
    if (trace.chunks.empty() || trace.chunks.back().code != chunk) {
      trace.chunks.push_back({chunk, static_cast<std::uint32_t>(trace.entries.size()), 0, trace.masks.size()});
    }
    TraceEntry entry{static_cast<std::uint16_t>(code & 511), 0, 0};
    std::uint64_t* masks = trace.masks.reserve(16);
    std::size_t count = 0;
    for (unsigned word = 0; word < 8; ++word) {
      const std::uint64_t missed = brick.missed[word] & ~brick.hit[word];
      if (missed == 0) continue;
      entry.missed_words = static_cast<std::uint8_t>(entry.missed_words | 1u << word);
      masks[count++] = missed;
    }
    for (unsigned word = 0; word < 8; ++word) {
      if (brick.hit[word] == 0) continue;
      entry.hit_words = static_cast<std::uint8_t>(entry.hit_words | 1u << word);
      masks[count++] = brick.hit[word];
    }
    trace.masks.extend(count);
    *trace.entries.reserve(1) = entry;
    trace.entries.extend(1);
    ++trace.chunks.back().entries;
  }
  wide_.clear();
}

}  // namespace uwsim::bricks
