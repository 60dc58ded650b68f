#include "uwsim/mapping/bricks/address_layout.h"

#include <algorithm>
#include <bit>

namespace uwsim::bricks {

AddressLayout::AddressLayout(const Key& origin, const std::uint16_t* const* end_key, std::size_t count) {
  bits = kChunkBits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint16_t* const keys = end_key[axis];
    const auto [lowest, highest] = std::minmax_element(keys, keys + count);
    // Rounding may take a ray one voxel past its end.
    const std::uint32_t first = std::min<std::uint32_t>(*lowest, origin[axis]) - 1;
    const std::uint32_t last = std::max<std::uint32_t>(*highest, origin[axis]) + 1;
    first_chunk[axis] = first >> 6;
    chunks[axis] = (last >> 6) - first_chunk[axis] + 1;
    shift[axis] = bits;
    const int chunk_bits = std::bit_width(chunks[axis] - 1);
    axis_mask[axis] = static_cast<std::uint64_t>(kSpread[63]) << axis | ((std::uint64_t{1} << chunk_bits) - 1) << bits;
    bits += chunk_bits;
  }
  fits_table = bits <= kTableBits;
  if (!fits_table) {
    for (std::size_t axis = 0; axis < 3; ++axis) axis_mask[axis] = morton::spread(0xffff) << axis;
  }
}

}  // namespace uwsim::bricks
