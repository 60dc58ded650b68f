#include "uwsim/mapping/map_changes.h"

#include <algorithm>
#include <bit>

#include "uwsim/core/check.h"
#include "uwsim/mapping/morton.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

}  // namespace

std::vector<MapChanges::States> MapChanges::ChunkStates::unpacked() const {
  std::vector<States> bricks(512);
  std::size_t next = 0;
  for (std::size_t i = 0; i < 512; ++i) {
    if (kinds[i] == Kind::mixed) {
      bricks[i] = mixed[next++];
    } else {
      std::fill_n(bricks[i].known, 8, kinds[i] == Kind::unknown ? 0 : kAll);
      std::fill_n(bricks[i].occupied, 8, kinds[i] == Kind::occupied ? kAll : 0);
    }
  }
  return bricks;
}

MapChanges::ChunkStates MapChanges::packed(const std::vector<States>& bricks) {
  ChunkStates chunk;
  for (std::size_t i = 0; i < 512; ++i) {
    const auto all = [](const std::uint64_t* words, std::uint64_t value) {
      return std::all_of(words, words + 8, [&](std::uint64_t word) { return word == value; });
    };
    const bool all_known = all(bricks[i].known, kAll);
    if (all(bricks[i].known, 0)) {
      chunk.kinds[i] = Kind::unknown;
    } else if (all_known && all(bricks[i].occupied, 0)) {
      chunk.kinds[i] = Kind::free;
    } else if (all_known && all(bricks[i].occupied, kAll)) {
      chunk.kinds[i] = Kind::occupied;
    } else {
      chunk.kinds[i] = Kind::mixed;
      chunk.mixed.push_back(bricks[i]);
    }
  }
  return chunk;
}

std::vector<MapChanges::States> MapChanges::states_now(const MapEngine& engine, std::uint32_t chunk) {
  std::vector<States> bricks(512);
  engine.for_each_leaf_in(chunk_box(chunk), [&](const VoxelKey& corner, int levels, float log_odds) {
    const std::size_t first = levels > 6 ? 0 : morton::code(corner) & 0x3ffff;
    const std::size_t count = std::size_t{1} << (3 * std::min(levels, 6));
    const bool occupied = is_occupied(log_odds);
    for (std::size_t at = first; at < first + count; at += 64) {
      const std::uint64_t bits = morton::bits_in_word(at, std::min<std::size_t>(count, 64));
      States& brick = bricks[at >> 9];
      brick.known[at >> 6 & 7] |= bits;
      if (occupied) brick.occupied[at >> 6 & 7] |= bits;
    }
  });
  return bricks;
}

void MapChanges::append_changes(std::uint32_t chunk, const std::vector<States>& before, const std::vector<States>& now,
                                std::vector<Changed>& changed) {
  for (std::size_t word = 0; word < 4096; ++word) {
    const States &a = before[word >> 3], &b = now[word >> 3];
    const std::size_t w = word & 7;
    for (std::uint64_t bits = (a.known[w] ^ b.known[w]) | (a.occupied[w] ^ b.occupied[w]); bits; bits &= bits - 1) {
      const int bit = std::countr_zero(bits);
      const bool known = b.known[w] >> bit & 1, occupied = b.occupied[w] >> bit & 1;
      const std::uint64_t code = std::uint64_t{chunk} << 18 | word << 6 | static_cast<std::uint64_t>(bit);
      changed.push_back({morton::key(code), static_cast<std::int8_t>(known ? occupied : -1)});
    }
  }
}

void MapChanges::note(const ChangedChunks& chunks) {
  pending_.all = pending_.all || chunks.all;
  pending_.codes.insert(chunks.codes.begin(), chunks.codes.end());
}

/// If all chunks may have changed, lists those that contain known voxels.
void MapChanges::list_pending(const MapEngine& engine, std::size_t most) {
  if (!pending_.all) return;
  std::uint64_t voxels = 0;
  ChangedChunks known;
  engine.for_each_leaf([&](const VoxelKey& corner, int levels, float) {
    voxels += std::uint64_t{1} << (3 * levels);
    if (voxels <= most) known.add(corner, levels);
  });
  require(voxels <= most, "map.known_voxels", voxels, "too many to list (100 million at most)");
  pending_.codes.merge(known.codes);
}

std::vector<MapChanges::Changed> MapChanges::take(const MapEngine& engine, std::size_t most) {
  list_pending(engine, most);
  std::vector<Changed> changed;
  std::map<std::uint32_t, ChunkStates> latest;
  for (const std::uint32_t chunk : pending_.codes) {
    const std::vector<States> now = states_now(engine, chunk);
    const auto reported = reported_.find(chunk);
    append_changes(chunk, reported == reported_.end() ? std::vector<States>(512) : reported->second.unpacked(), now,
                   changed);
    require(changed.size() <= most, "map.changed_voxels", changed.size(), "too many to list (100 million at most)");
    latest[chunk] = packed(now);
  }
  for (auto& [chunk, states] : latest) reported_[chunk] = std::move(states);
  pending_ = {};
  return changed;
}

}  // namespace uwsim
