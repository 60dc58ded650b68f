#include "uwsim/mapping/map_changes.h"

#include <algorithm>
#include <bit>

#include "uwsim/core/check.h"
#include "uwsim/mapping/morton.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

std::uint64_t code_of(const VoxelKey& key) {
  const auto axis = [&](std::size_t i) { return static_cast<std::uint32_t>(key[i]); };
  return morton::code(axis(0), axis(1), axis(2));
}

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
    const bool uniform = all(bricks[i].known, kAll);
    if (all(bricks[i].known, 0)) {
      chunk.kinds[i] = Kind::unknown;
    } else if (uniform && all(bricks[i].occupied, 0)) {
      chunk.kinds[i] = Kind::free;
    } else if (uniform && all(bricks[i].occupied, kAll)) {
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
    const std::size_t first = levels > 6 ? 0 : code_of(corner) & 0x3ffff;
    const std::size_t count = std::size_t{1} << (3 * std::min(levels, 6));
    const bool occupied = OccupancyModel::is_occupied(log_odds);
    for (std::size_t at = first; at < first + count; at += 64) {
      const std::size_t in_word = std::min<std::size_t>(count, 64);
      const std::uint64_t bits = (in_word == 64 ? kAll : (std::uint64_t{1} << in_word) - 1) << (at & 63);
      States& brick = bricks[at >> 9];
      brick.known[at >> 6 & 7] |= bits;
      if (occupied) brick.occupied[at >> 6 & 7] |= bits;
    }
  });
  return bricks;
}

std::vector<MapChanges::Changed> MapChanges::take(MapEngine& engine, std::size_t most) {
  const ChangedChunks latest = engine.take_changed();
  pending_.all = pending_.all || latest.all;
  pending_.codes.insert(latest.codes.begin(), latest.codes.end());
  if (pending_.all) {
    std::uint64_t voxels = 0;
    ChangedChunks known;
    engine.for_each_leaf([&](const VoxelKey& corner, int levels, float) {
      voxels += std::uint64_t{1} << (3 * levels);
      if (voxels <= most) known.add(corner, levels);
    });
    require(voxels <= most, "map.known_voxels", voxels, "too many to list (100 million at most)");
    pending_.codes.merge(known.codes);
  }
  std::vector<Changed> changed;
  std::map<std::uint32_t, ChunkStates> told;
  for (const std::uint32_t chunk : pending_.codes) {
    const std::vector<States> now = states_now(engine, chunk);
    const auto before_at = told_.find(chunk);
    const std::vector<States> before =
        before_at == told_.end() ? std::vector<States>(512) : before_at->second.unpacked();
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
    require(changed.size() <= most, "map.changed_voxels", changed.size(), "too many to list (100 million at most)");
    told[chunk] = packed(now);
  }
  for (auto& [chunk, states] : told) told_[chunk] = std::move(states);
  pending_ = {};
  return changed;
}

}  // namespace uwsim
