#include <cstring>

#include "uwsim/mapping/brick_tree.h"

namespace uwsim::bricks {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

class Loader {
 public:
  Loader(BrickStore& store, std::string_view body) : store_(store), supply_(store), body_(body) {}

  void binary_node(int levels, std::uint64_t code) {
    const auto codes = take<std::uint16_t>();
    for (unsigned child = 0; child < 8; ++child) {
      const std::uint64_t below = code + (std::uint64_t{child} << (3 * (levels - 1)));
      switch (codes >> (2 * child) & 3) {
        case 1:
          fill(levels - 1, below, store_.model().lowest);
          break;
        case 2:
          fill(levels - 1, below, store_.model().highest);
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
    if (chunk_code != chunk_code_) store_.make_room();
    chunk_code_ = chunk_code;
    BrickStore::Chunk& chunk = store_.chunk(chunk_code);
    const std::size_t brick = code >> 9 & 511;
    if (levels < 3) return fill_voxels(supply_.open(chunk.bricks[brick]), code & 511, 1u << (3 * levels), log_odds);
    const std::uint32_t slot = store_.uniform_slot(log_odds);
    std::fill_n(chunk.bricks.begin() + static_cast<std::ptrdiff_t>(brick), std::size_t{1} << (3 * (levels - 3)), slot);
  }

  void fill_voxels(Brick& brick, std::uint64_t first, unsigned count, float log_odds) {
    const std::size_t word = first >> 6;
    const std::uint64_t bits = (count == 64 ? kAll : (std::uint64_t{1} << count) - 1) << (first & 63);
    const std::uint64_t known = brick.known[word];
    brick.known[word] |= bits;
    if (log_odds <= store_.model().lowest) brick.low[word] |= bits;
    if (brick.block[word] == kNone && log_odds == store_.model().lowest) return;
    Blocks& supply = supply_.blocks(1);
    if (brick.block[word] == kNone) {
      brick.block[word] = supply.free[--supply.free_count];
      float* const block = supply.at(brick.block[word]);
      for (int i = 0; i < 64; ++i) block[i] = known >> i & 1 ? store_.model().lowest : 0.0f;
    }
    std::fill_n(supply.at(brick.block[word]) + (first & 63), count, log_odds);
  }

  BrickStore& store_;
  BrickStore::Supply supply_;
  std::string_view body_;
  std::size_t at_ = 0;
  std::uint32_t chunk_code_ = kNone;
};

}  // namespace

void load_tree(BrickStore& store, MapFormat format, std::string_view body) {
  Loader loader(store, body);
  format == MapFormat::bt ? loader.binary_node(kTreeDepth, 0) : loader.full_node(kTreeDepth, 0);
}

}  // namespace uwsim::bricks
