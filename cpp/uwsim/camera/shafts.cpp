#include "uwsim/camera/shafts.h"

#include <algorithm>

#include "uwsim/camera/parts.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::kBlockPixels;
using camera::kBlockSide;

constexpr int kSamples = 8;

class ShaftCaster {
 public:
  ShaftCaster(const camera::Shot& shot, const Tracer& tracer, const camera::Kernels& kernels, const Exposure& exposure)
      : shot_(shot),
        tracer_(tracer),
        kernels_(kernels),
        exposure_(exposure),
        columns_((shot.width + kBlockSide - 1) / kBlockSide),
        rows_((shot.height + kBlockSide - 1) / kBlockSide),
        light_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 1.0f) {}

  /// Four rows of blocks at a time.
  int strips() const { return (rows_ + kBlockSide - 1) / kBlockSide; }

  void cast(int strip, PictureCost& cost) {
    StageClock clock(exposure_.measure, cost);
    Block block;
    HitPacket hits;
    for (int left = 0; left < columns_; left += kBlockSide) {
      const int top = strip * kBlockSide;
      // The rays of pixels (2, 2) of their blocks: the nearest to the middle.
      kernels_.aim_shafts(shot_, left * kBlockSide + 2, top * kBlockSide + 2, kBlockSide, block);
      tracer_.cast(block, hits, RayOrder::kCoherent);
      cost.shaft_rays += count(block.active);
      clock.add(kShaftRays);
      kernels_.open_eye(shot_, block);
      kernels_.pass_water(shot_, block);
      sample(left, top, block, cost, clock);
    }
  }

  std::vector<float> smoothed() const {
    std::vector<float> out(light_.size());
    const auto at = [&](int x, int y) {
      return light_[static_cast<std::size_t>(std::clamp(y, 0, rows_ - 1) * columns_ + std::clamp(x, 0, columns_ - 1))];
    };
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        const auto row = [&](int v) { return 0.25f * at(x - 1, v) + 0.5f * at(x, v) + 0.25f * at(x + 1, v); };
        out[static_cast<std::size_t>(y * columns_ + x)] = 0.25f * row(y - 1) + 0.5f * row(y) + 0.25f * row(y + 1);
      }
    }
    return out;
  }

 private:
  void sample(int left, int top, Block& block, PictureCost& cost, StageClock& clock) {
    std::array<float, kBlockPixels> lit{}, whole{};
    block.normal = {};
    block.distance = {};
    for (int k = 0; k < kSamples; ++k) {
      camera::Row weight, caustic;
      camera::Mask blocked{};
      kernels_.shaft_sample(shot_, (static_cast<float>(k) + 0.5f) / kSamples, block, weight, caustic);
      clock.add(kWater);
      if (exposure_.effects.has(Effect::kShadows) && any(block.wants)) {
        cost.shaft_rays += count(block.wants);
        tracer_.occluded(block, blocked, RayOrder::kCoherent);
      }
      clock.add(kShaftRays);
      for (std::size_t lane = 0; lane < kBlockPixels; ++lane) {
        whole[lane] += weight.at[lane];
        lit[lane] += blocked.at[lane] ? 0.0f : weight.at[lane] * caustic.at[lane];
      }
    }
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int x = left + lane % kBlockSide, y = top + lane / kBlockSide;
      if (x >= columns_ || y >= rows_ || !(whole[static_cast<std::size_t>(lane)] > 0)) continue;
      light_[static_cast<std::size_t>(y * columns_ + x)] =
          lit[static_cast<std::size_t>(lane)] / whole[static_cast<std::size_t>(lane)];
    }
  }

  const camera::Shot& shot_;
  const Tracer& tracer_;
  const camera::Kernels& kernels_;
  const Exposure& exposure_;
  int columns_, rows_;
  std::vector<float> light_;
};

}  // namespace

std::vector<float> cast_shafts(const camera::Shot& shot, const Tracer& tracer, const camera::Kernels& kernels,
                               const Exposure& exposure, std::vector<PictureCost>& costs) {
  ShaftCaster caster(shot, tracer, kernels, exposure);
  for_rows(caster.strips(), static_cast<int>(costs.size()),
           [&](int strip, int worker) { caster.cast(strip, costs[static_cast<std::size_t>(worker)]); });
  return caster.smoothed();
}

}  // namespace uwsim
