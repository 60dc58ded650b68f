#include "uwsim/mapping/occupied_changes.h"

#include <bit>

#include "uwsim/core/check.h"
#include "uwsim/mapping/morton.h"

namespace uwsim {

void OccupiedChanges::note(const ChangedChunks& chunks) {
  pending_.all = pending_.all || chunks.all;
  pending_.codes.insert(chunks.codes.begin(), chunks.codes.end());
}

std::vector<OccupiedChanges::Changed> OccupiedChanges::take(const MapEngine& engine, std::size_t most) {
  if (pending_.all) {
    ChangedChunks chunks = engine.occupied_chunks();
    require(!chunks.all, "map.occupied_voxels", "a cube of 2,048 voxels an edge",
            "too many to list (100 million at most)");
    pending_.codes.merge(chunks.codes);
    for (const auto& [chunk, words] : reported_) pending_.codes.insert(chunk);
  }
  std::vector<Changed> changed;
  std::vector<std::pair<std::uint32_t, Words>> latest;
  for (const std::uint32_t chunk : pending_.codes) {
    OccupiedWords now{};
    engine.occupied_in(chunk, now);
    OccupiedWords before{};
    if (const auto found = reported_.find(chunk); found != reported_.end()) {
      for (const auto& [word, bits] : found->second) before[word] = bits;
    }
    Words words;
    for (std::size_t word = 0; word < now.size(); ++word) {
      if (now[word]) words.emplace_back(static_cast<std::uint16_t>(word), now[word]);
      for (std::uint64_t bits = before[word] ^ now[word]; bits; bits &= bits - 1) {
        const int bit = std::countr_zero(bits);
        const std::uint64_t code = std::uint64_t{chunk} << 18 | word << 6 | static_cast<std::uint64_t>(bit);
        changed.push_back({morton::key(code), (now[word] >> bit & 1) != 0});
      }
    }
    require(changed.size() <= most, "map.changed_occupancy", changed.size(), "too many to list (100 million at most)");
    latest.emplace_back(chunk, std::move(words));
  }
  for (auto& [chunk, words] : latest) reported_[chunk] = std::move(words);
  pending_ = {};
  return changed;
}

}  // namespace uwsim
