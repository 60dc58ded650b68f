#include "uwsim/camera/shafts.h"

#include <algorithm>

#include "uwsim/camera/parts.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::kBlockPixels;
using camera::kBlockSide;

constexpr int kSamples = 8;
constexpr int kShare = 2;  // values a side that share shadow rays, and the way's end
constexpr int kGroup = kShare * kBlockSide;

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

  /// Two rows of blocks of values at a time.
  int strips() const { return (rows_ + kGroup - 1) / kGroup; }

  void cast(int strip, PictureCost& cost) {
    StageClock clock(exposure_.measure, cost);
    Shadows shadows;
    for (int left = 0; left < columns_; left += kGroup) {
      const int top = strip * kGroup;
      test(left, top, shadows, cost, clock);
      for (int part = 0; part < kShare * kShare; ++part) {
        const int x = part % kShare * kBlockSide, y = part / kShare * kBlockSide;
        if (left + x < columns_ && top + y < rows_) sample(left + x, top + y, x, y, shadows);
      }
      clock.add(kWater);
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
  /// Of a group of values: where ways end, and what of them lies in shadow.
  struct Shadows {
    camera::Row distance;
    std::array<camera::Mask, kSamples> blocked;
  };

  static float middle(int k) { return (static_cast<float>(k) + 0.5f) / kSamples; }

  /// Rays of the pixels at `offset` of their blocks, at the eye.
  void aim(int left, int top, int offset, int scale, Block& block) const {
    kernels_.aim_shafts(shot_, left * kBlockSide + offset, top * kBlockSide + offset, scale, block);
    kernels_.open_eye(shot_, block);
  }

  void test(int left, int top, Shadows& shadows, PictureCost& cost, StageClock& clock) const {
    Block block;
    HitPacket hits;
    aim(left, top, kGroup / 2, kGroup, block);
    tracer_.cast(block, hits, RayOrder::kCoherent);
    cost.shaft_rays += count(block.active);
    shadows.distance = block.distance;
    shadows.blocked = {};
    if (exposure_.effects.has(Effect::kShadows)) {
      kernels_.pass_water(shot_, block);
      block.normal = {};
      for (int k = 0; k < kSamples; ++k) {
        kernels_.shaft_point(shot_, middle(k), block);
        if (!any(block.wants)) continue;
        cost.shaft_rays += count(block.wants);
        tracer_.occluded(block, shadows.blocked[static_cast<std::size_t>(k)], RayOrder::kCoherent);
      }
    }
    clock.add(kShaftRays);
  }

  /// Values from (left, top), which is (x, y) of its group.
  void sample(int left, int top, int x, int y, const Shadows& shadows) {
    Block block;
    std::array<std::size_t, kBlockPixels> shared;
    aim(left, top, kBlockSide / 2, kBlockSide, block);
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int column = (x + lane % kBlockSide) / kShare, row = (y + lane / kBlockSide) / kShare;
      shared[static_cast<std::size_t>(lane)] = static_cast<std::size_t>(row * kBlockSide + column);
      block.distance.at[lane] = shadows.distance.at[row * kBlockSide + column];
    }
    kernels_.pass_water(shot_, block);
    std::array<float, kBlockPixels> lit{}, whole{};
    for (int k = 0; k < kSamples; ++k) {
      const camera::Mask& blocked = shadows.blocked[static_cast<std::size_t>(k)];
      camera::Row weight, caustic;
      kernels_.shaft_point(shot_, middle(k), block);
      kernels_.shaft_light(shot_, block, weight, caustic);
      for (std::size_t lane = 0; lane < kBlockPixels; ++lane) {
        whole[lane] += weight.at[lane];
        lit[lane] += blocked.at[shared[lane]] ? 0.0f : weight.at[lane] * caustic.at[lane];
      }
    }
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int i = left + lane % kBlockSide, j = top + lane / kBlockSide;
      if (i >= columns_ || j >= rows_ || !(whole[static_cast<std::size_t>(lane)] > 0)) continue;
      light_[static_cast<std::size_t>(j * columns_ + i)] =
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
