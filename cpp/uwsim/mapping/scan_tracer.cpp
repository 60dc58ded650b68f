#include "uwsim/mapping/scan_tracer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

constexpr int kChunkBits = 18;  // of a voxel's address within its chunk of 64 x 64 x 64
/// The table's addresses have 32 bits: two times 512 MB of addresses, of which only what rays touch takes memory.
constexpr int kTableBits = 32;
constexpr std::size_t kLanes = 32;

constexpr std::array<std::uint32_t, 64> kSpread = [] {
  std::array<std::uint32_t, 64> table{};
  for (std::uint32_t i = 0; i < 64; ++i) table[i] = static_cast<std::uint32_t>(morton::spread(i));
  return table;
}();

}  // namespace

void ScanTrace::clear() {
  chunks.clear();
  entries.clear();
  masks.clear();
}

std::uint64_t ScanTracer::Layout::address(const Key& key) const {
  if (!in_table) return morton::code(key[0], key[1], key[2]);
  std::uint64_t address = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    address |= static_cast<std::uint64_t>(kSpread[key[axis] & 63]) << axis;
    address |= static_cast<std::uint64_t>((key[axis] >> 6) - first_chunk[axis]) << shift[axis];
  }
  return address;
}

void ScanTracer::make_room(std::size_t rays) {
  if (rays <= capacity_) return;
  capacity_ = 0;  // until all of them have it: there may be no memory
  columns_.resize(7 * rays);
  keys_.resize(3 * rays);
  flags_.resize(2 * rays);
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
  rays_.negative = flags_.data();
  rays_.kind = flags_.data() + rays;
  if (kernels_.slabs) make_slab_room(rays);
  capacity_ = rays;
}

void ScanTracer::make_slab_room(std::size_t rays) {
  slab_columns_.resize(10 * rays);
  slab_order_.resize(rays);
  way_.resize(rays);
  slab_rays_.way = way_.data();
  std::uint32_t* column = slab_columns_.data();
  for (std::uint32_t** to : {&slab_rays_.slabs, &slab_rays_.flags, &slab_rays_.slope, &slab_rays_.fraction,
                             &slab_rays_.minor_slab, &slab_rays_.minor_fraction, &slab_rays_.minor_slabs,
                             &slab_rays_.minor_slabs_fraction, &slab_rays_.minor_middle, &slab_rays_.minor_middles}) {
    *to = std::exchange(column, column + rays);
  }
}

ScanTracer::Layout ScanTracer::layout_of(std::size_t count, const Key& origin) const {
  Layout layout{};
  int shift = kChunkBits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint16_t* const keys = rays_.end_key[axis];
    const auto [lowest, highest] = std::minmax_element(keys, keys + count);  // of skipped ones: the origin's
    // By rounding a ray may step past its end, by one voxel.
    const std::uint32_t first = std::min<std::uint32_t>(*lowest, origin[axis]) - 1;
    const std::uint32_t last = std::max<std::uint32_t>(*highest, origin[axis]) + 1;
    layout.first_chunk[axis] = first >> 6;
    layout.chunks[axis] = (last >> 6) - layout.first_chunk[axis] + 1;
    layout.shift[axis] = shift;
    const int bits = std::bit_width(layout.chunks[axis] - 1);
    layout.axis_mask[axis] = static_cast<std::uint64_t>(kSpread[63]) << axis | ((std::uint64_t{1} << bits) - 1)
                                                                                   << shift;
    shift += bits;
  }
  layout.in_table = shift <= kTableBits;
  if (!layout.in_table) {
    for (std::size_t axis = 0; axis < 3; ++axis) layout.axis_mask[axis] = morton::spread(0xffff) << axis;
  }
  return layout;
}

/// Which rays are walked by slabs. They go by ways, then by their numbers of slabs in a few steps: so that neighbours
/// stay together, of which many mark the same voxels.
void ScanTracer::sort_out_slabs(std::size_t count, const Key& origin) {
  constexpr std::size_t kSteps = 16, kBuckets = 4 * kSteps;
  slabs_ = {&rays_, count, {origin[0], origin[1], origin[2]}, &slab_rays_, slab_order_.data(), {}};
  kernels_.slabs->sort_out(slabs_);
  std::uint32_t most = 1;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, way_[i] != 0 ? slab_rays_.slabs[i] : 0);
  const auto bucket = [&](std::size_t i) { return (way_[i] - 1) * kSteps + slab_rays_.slabs[i] * (kSteps - 1) / most; };
  std::array<std::uint32_t, kBuckets + 1> starts{};
  for (std::size_t i = 0; i < count; ++i) {
    if (way_[i] == 0) continue;
    ++starts[bucket(i) + 1];
    ++slabs_.first[way_[i]];
    steps_[i] = 0;  // no other walk
  }
  for (std::size_t way = 0; way < 4; ++way) slabs_.first[way + 1] += slabs_.first[way];
  for (std::size_t i = 0; i < kBuckets; ++i) starts[i + 1] += starts[i];
  for (std::size_t i = 0; i < count; ++i) {
    if (way_[i] != 0) slab_order_[starts[bucket(i)]++] = static_cast<std::uint32_t>(i);
  }
}

/// The order of the walks: by their number of steps, so that those side by side end together.
void ScanTracer::aim(std::size_t count, const Layout& layout) {
  constexpr std::size_t kBuckets = 1024;
  std::array<std::uint32_t, kBuckets + 1> starts{};
  const std::uint32_t longest = *std::max_element(steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(count));
  const int shift = std::max(0, static_cast<int>(std::bit_width(longest)) - 10);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t address = layout.address({rays_.end_key[0][i], rays_.end_key[1][i], rays_.end_key[2][i]});
    std::uint64_t mirror = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (rays_.negative[i] >> axis & 1) mirror |= layout.axis_mask[axis];
    }
    address_[i] = address;
    end_address_[i] = address ^ mirror;
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

void ScanTracer::walk(const Layout& layout, std::uint64_t origin_address) {
  WalkInput input{};
  input.rays = &rays_;
  input.order = order_.data();
  input.count = order_.size() - kLanes;
  input.end_address = end_address_.data();
  input.origin_address = origin_address;
  std::copy_n(layout.axis_mask.begin(), 3, input.axis_mask);
  if (layout.in_table) {
    input.table = tables_.free();
    input.touched = tables_.touched();
  } else {
    input.context = &wide_;
    input.put = [](void* context, std::uint64_t word, std::uint64_t mask) {
      (*static_cast<decltype(wide_)*>(context))[word >> 3].free[word & 7] |= mask;
    };
  }
  kernels_.walk(input);
  if (kernels_.slabs && layout.in_table) kernels_.slabs->walk(slabs_, input);
}

void ScanTracer::mark_hits(std::size_t count, const Layout& layout) {
  std::uint64_t* const table = tables_.hit();
  std::uint8_t* const touched = tables_.touched();
  for (std::size_t i = 0; i < count; ++i) {
    if (rays_.kind[i] != kHit) continue;
    const std::uint64_t address = address_[i], bit = std::uint64_t{1} << (address & 63);
    if (layout.in_table) {
      table[address >> 6] |= bit;
      touched[address >> 9] |= 2;
    } else {
      wide_[address >> 9].hit[address >> 6 & 7] |= bit;
    }
  }
}

void ScanTracer::trace(const ScanInput& scan, ScanTrace& trace) {
  trace.clear();
  wide_.clear();  // of a scan that memory did not do for
  if (scan.count == 0) return;
  make_room(scan.count);
  kernels_.start_rays(scan, rays_);
  Key origin{};
  const double factor = 1.0 / scan.resolution_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    origin[axis] = static_cast<std::uint32_t>(static_cast<int>(std::floor(factor * scan.origin_m[axis])) + 32768);
  }
  const Layout layout = layout_of(scan.count, origin);
  if (layout.in_table) tables_.begin(layout.shift[2] + std::bit_width(layout.chunks[2] - 1));
  if (kernels_.slabs && layout.in_table) sort_out_slabs(scan.count, origin);
  aim(scan.count, layout);
  walk(layout, layout.address(origin));
  mark_hits(scan.count, layout);
  if (!layout.in_table) return collect_wide(trace);
  collect(layout, trace);
  tables_.end();
}

void ScanTracer::collect(const Layout& layout, ScanTrace& trace) {
  for (std::uint32_t z = 0; z < layout.chunks[2]; ++z) {
    for (std::uint32_t y = 0; y < layout.chunks[1]; ++y) {
      for (std::uint32_t x = 0; x < layout.chunks[0]; ++x) {
        const std::size_t chunk = (std::size_t{x} << layout.shift[0] | std::size_t{y} << layout.shift[1] |
                                   std::size_t{z} << layout.shift[2]) >>
                                  kChunkBits;
        const Collected found =
            kernels_.collect({tables_.free() + 4096 * chunk, tables_.hit() + 4096 * chunk,
                              tables_.touched() + 512 * chunk, trace.entries.room(512), trace.masks.room(8200)});
        if (found.entries == 0) continue;
        const std::uint64_t code =
            morton::code(layout.first_chunk[0] + x, layout.first_chunk[1] + y, layout.first_chunk[2] + z);
        trace.chunks.push_back({static_cast<std::uint32_t>(code), static_cast<std::uint32_t>(trace.entries.size()),
                                static_cast<std::uint32_t>(found.entries), trace.masks.size()});
        trace.entries.grow(found.entries);
        trace.masks.grow(found.masks);
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
    Entry entry{static_cast<std::uint16_t>(code & 511), 0, 0};
    std::uint64_t* masks = trace.masks.room(16);
    std::size_t count = 0;
    for (unsigned word = 0; word < 8; ++word) {
      const std::uint64_t free = brick.free[word] & ~brick.hit[word];
      if (free == 0) continue;
      entry.free_words = static_cast<std::uint8_t>(entry.free_words | 1u << word);
      masks[count++] = free;
    }
    for (unsigned word = 0; word < 8; ++word) {
      if (brick.hit[word] == 0) continue;
      entry.hit_words = static_cast<std::uint8_t>(entry.hit_words | 1u << word);
      masks[count++] = brick.hit[word];
    }
    trace.masks.grow(count);
    *trace.entries.room(1) = entry;
    trace.entries.grow(1);
    ++trace.chunks.back().entries;
  }
  wide_.clear();
}

}  // namespace uwsim::bricks
