#include "uwsim/camera/lamp_glow.h"

#include <algorithm>
#include <cmath>

#include "uwsim/camera/parallel_rows.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::kBlockPixels;
using camera::kBlockSide;

// The error of bilinear interpolation is at most an eighth of the second differences along both axes: 0.1 % here.
constexpr float kSmooth = 8e-3f;
constexpr float kEndless_m = 2e4f;

}  // namespace

LampGlow::LampGlow(const camera::View& view, const camera::Kernels& kernels, int threads)
    : columns_((view.width + kBlockSide - 1) / kBlockSide), rows_((view.height + kBlockSide - 1) / kBlockSide) {
  const auto size = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  for (std::vector<float>& band : bands_) band.resize(size);
  is_smooth_.resize(size);
  for_rows((rows_ + kBlockSide - 1) / kBlockSide, threads, [&](int row, int) { sample(view, kernels, row); });
}

void LampGlow::show_in(camera::View& view) const {
  for (std::size_t band = 0; band < bands_.size(); ++band) view.glow.bands[band] = bands_[band].data();
  view.glow.is_smooth = is_smooth_.data();
}

/// Computes four rows of values.
void LampGlow::sample(const camera::View& view, const camera::Kernels& kernels, int row) {
  Block block;
  std::fill_n(block.reach.at, kBlockPixels, kEndless_m);
  for (int first = 0; first < columns_; first += kBlockSide) {
    const int left = kBlockSide * first + camera::kGlowPixel, top = kBlockSide * kBlockSide * row + camera::kGlowPixel;
    kernels.shaft_rays(view, left, top, kBlockSide, block);
    kernels.start_paths(view, block);
    kernels.add_glow(view, 0, 0, block);
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int i = first + lane % kBlockSide, j = kBlockSide * row + lane / kBlockSide;
      if (i >= columns_ || j >= rows_) continue;
      const auto at = static_cast<std::size_t>(j * columns_ + i);
      bands_[0][at] = block.radiance.x.at[lane];
      bands_[1][at] = block.radiance.y.at[lane];
      bands_[2][at] = block.radiance.z.at[lane];
    }
  }
}

void LampGlow::find_smooth(int row, int first, int last) {
  if (row == 0 || row == rows_ - 1) return;
  for (int column = std::max(first, 1); column < std::min(last, columns_ - 1); ++column) {
    const auto at = static_cast<std::size_t>(row * columns_ + column);
    const auto below = static_cast<std::size_t>(columns_);
    is_smooth_[at] = std::all_of(bands_.begin(), bands_.end(), [&](const std::vector<float>& band) {
      const float twice = 2 * band[at];
      return std::abs(band[at - 1] - twice + band[at + 1]) + std::abs(band[at - below] - twice + band[at + below]) <=
             kSmooth * band[at];
    });
  }
}

}  // namespace uwsim
