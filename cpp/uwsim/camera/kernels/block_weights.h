#pragma once

#include "uwsim/camera/kernels/block_lanes.h"
#include "uwsim/camera/kernels/view.h"

/// Interpolation between images with one value per block. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Weights of bilinear interpolation between blocks: the weights, for each lane, of the blocks before, at and after its
/// own along each axis.
struct BlockWeights {
  alignas(64) float across[3][kLanes], down[3][kLanes];
};

/// `middle`: where a block's value belongs, in pixels from its first pixel along each axis.
constexpr BlockWeights block_weights(float middle) {
  BlockWeights weights{};
  for (int k = 0; k < kLanes; ++k) {
    const float x = (static_cast<float>(k % kBlockSide) - middle) / kBlockSide;
    const float y = (static_cast<float>(k / kBlockSide) - middle) / kBlockSide;
    weights.across[0][k] = x < 0 ? -x : 0, weights.across[1][k] = 1 - (x < 0 ? -x : x),
    weights.across[2][k] = x < 0 ? 0 : x;
    weights.down[0][k] = y < 0 ? -y : 0, weights.down[1][k] = 1 - (y < 0 ? -y : y), weights.down[2][k] = y < 0 ? 0 : y;
  }
  return weights;
}

/// Indices of a block and its neighbours, which are the block itself beyond the picture's edge.
struct BlockNeighbours {
  int columns[3], rows[3];  ///< rows: index of the row's first block

  BlockNeighbours(const View& view, int left, int top) {
    const int width = (view.width + kBlockSide - 1) / kBlockSide, height = (view.height + kBlockSide - 1) / kBlockSide;
    const int i = left / kBlockSide, j = top / kBlockSide;
    columns[0] = i > 0 ? i - 1 : 0, columns[1] = i, columns[2] = i + 1 < width ? i + 1 : i;
    rows[0] = width * (j > 0 ? j - 1 : 0), rows[1] = width * j, rows[2] = width * (j + 1 < height ? j + 1 : j);
  }
};

UWSIM_LANES Float interpolate_blocks(const BlockWeights& weights, const BlockNeighbours& at, const float* values) {
  Float sum;
  for (int n = 0; n < 3; ++n) {
    const float* row = values + at.rows[n];
    const Float here = load(weights.across[0]) * row[at.columns[0]] + load(weights.across[1]) * row[at.columns[1]] +
                       load(weights.across[2]) * row[at.columns[2]];
    sum = sum + load(weights.down[n]) * here;
  }
  return sum;
}

}  // namespace
}  // namespace uwsim::camera
