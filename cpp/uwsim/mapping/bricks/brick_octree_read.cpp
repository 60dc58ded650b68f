#include <algorithm>
#include <cstring>

#include "uwsim/mapping/bricks/brick_allocator.h"
#include "uwsim/mapping/bricks/brick_octree.h"
#include "uwsim/mapping/morton.h"

namespace uwsim::bricks {
namespace {

/// Reads the nodes of a tree in preorder. A node's cube has an edge of 2^levels voxels; `code` is the Morton code of
/// the cube's lowest voxel.
class OctreeReader {
 public:
  OctreeReader(BrickStore& store, std::string_view body) : store_(store), allocator_(store), body_(body) {}

  void binary_node(int levels, std::uint64_t code) {
    const auto codes = take<std::uint16_t>();
    for (unsigned child = 0; child < 8; ++child) {
      const std::uint64_t below = code + (std::uint64_t{child} << (3 * (levels - 1)));
      switch (codes >> (2 * child) & 3) {
        case 1:
          fill(levels - 1, below, store_.model().clamping_min);
          break;
        case 2:
          fill(levels - 1, below, store_.model().clamping_max);
          break;
        case 3:
          binary_node(levels - 1, below);
          break;
        default:
          break;
      }
    }
  }

  void full_node(int levels, std::uint64_t code) {
    const auto log_odds = take<float>();
    const auto flags = take<std::uint8_t>();
    if (flags == 0) return fill(levels, code, log_odds);
    for (unsigned child = 0; child < 8; ++child) {
      if (flags >> child & 1) full_node(levels - 1, code + (std::uint64_t{child} << (3 * (levels - 1))));
    }
  }

 private:
  template <typename Value>
  Value take() {
    Value value;
    std::memcpy(&value, body_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }

  void fill(int levels, std::uint64_t code, float log_odds) {
    const auto chunk_code = static_cast<std::uint32_t>(code >> 18);
    if (levels > 6) return store_.add_large_leaf({chunk_code, levels, log_odds});
    BrickStore::Chunk& chunk = store_.writable_chunk(chunk_code);
    const std::size_t brick = code >> 9 & 511;
    if (levels < 3) {
      return fill_voxels(allocator_.writable(chunk.bricks[brick]), code & 511, std::size_t{1} << (3 * levels),
                         log_odds);
    }
    const std::uint32_t slot = store_.uniform_slot(log_odds);
    std::fill_n(chunk.bricks.begin() + static_cast<std::ptrdiff_t>(brick), std::size_t{1} << (3 * (levels - 3)), slot);
  }

  void fill_voxels(Brick& brick, std::uint64_t first, std::size_t count, float log_odds) {
    const int word = static_cast<int>(first >> 6);
    const std::uint64_t bits = morton::bits_in_word(first, count);
    const float clamping_min = store_.model().clamping_min;
    if (log_odds <= clamping_min) brick.at_min[word] |= bits;
    if (brick.block[word] != kNone || log_odds != clamping_min) {
      std::fill_n(allocator_.writable_block(brick, word, clamping_min) + (first & 63), count, log_odds);
    }
    brick.known[word] |= bits;
  }

  BrickStore& store_;
  BrickAllocator allocator_;
  std::string_view body_;
  std::size_t at_ = 0;
};

}  // namespace

void load_tree(BrickStore& store, MapFormat format, std::string_view body) {
  OctreeReader reader(store, body);
  format == MapFormat::bt ? reader.binary_node(kTreeDepth, 0) : reader.full_node(kTreeDepth, 0);
}

}  // namespace uwsim::bricks
