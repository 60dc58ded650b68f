#include "uwsim/camera/shafts.h"

#include <algorithm>
#include <array>
#include <utility>

#include "uwsim/camera/block_mask.h"
#include "uwsim/camera/parallel_rows.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::kBlockPixels;
using camera::kBlockSide;

constexpr int kSamples = 8;
constexpr int kShare = 2;  // groups of 2 x 2 values share shadow rays and the end of the ray
constexpr int kGroup = kShare * kBlockSide;
constexpr float kSharpness = 8;  // as kShaftSharpness of kernels/shafts.h

class ShaftCaster {
 public:
  ShaftCaster(const camera::View& view, const Tracer& tracer, const camera::Kernels& kernels,
              const PictureRequest& request)
      : view_(view),
        tracer_(tracer),
        kernels_(kernels),
        request_(request),
        columns_((view.width + kBlockSide - 1) / kBlockSide),
        rows_((view.height + kBlockSide - 1) / kBlockSide),
        light_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 1.0f),
        reach_m_(light_.size(), 0.0f) {}

  /// A strip is half of two rows of blocks of values.
  int strips() const { return 2 * ((rows_ + kGroup - 1) / kGroup); }

  void cast(int strip, RenderCost& cost) {
    TaskTimer timer(request_.measure, cost);
    Shadows shadows;
    const int top = strip / 2 * kGroup, groups = (columns_ + kGroup - 1) / kGroup, half = (groups + 1) / 2;
    const int first = strip % 2 == 0 ? 0 : half, last = strip % 2 == 0 ? half : groups;
    for (int left = first * kGroup; left < last * kGroup; left += kGroup) {
      cast_shared(left, top, shadows, cost, timer);
      for (int part = 0; part < kShare * kShare; ++part) {
        const int x = part % kShare * kBlockSide, y = part / kShare * kBlockSide;
        if (left + x < columns_ && top + y < rows_) sample(left + x, top + y, x, y, shadows, cost);
      }
      timer.add(kWater);
    }
  }

  /// The light, each value mixed with those of its neighbours whose rays end about as far away.
  ShaftImage smoothed() && {
    std::vector<float> out(light_.size());
    constexpr std::array<float, 3> kShare{0.25f, 0.5f, 0.25f};
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        const int here = y * columns_ + x;
        const float own_m = reach_m_[here], per_m = kSharpness / std::max(own_m, 0.1f);
        float sum = 0, whole = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, rows_ - 1); ++v) {
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, columns_ - 1); ++u) {
            const int there = v * columns_ + u;
            const float apart = (reach_m_[there] - own_m) * per_m;
            const float weight = kShare[v - y + 1] * kShare[u - x + 1] / (1 + apart * apart * apart * apart);
            sum += weight * light_[there], whole += weight;
          }
        }
        out[here] = sum / whole;
      }
    }
    return {std::move(out), std::move(reach_m_)};
  }

 private:
  /// Data shared by a group of values: the ends of rays, unless these are at different distances, and which of their
  /// sample points are in shadow.
  struct Shadows {
    camera::BlockFloats distance;
    bool is_even;  // the rays end about as far away
    std::array<camera::BlockMask, kSamples> blocked;
  };

  static float sample_share(int k) { return (static_cast<float>(k) + 0.5f) / kSamples; }

  /// Starts paths through the pixels at `offset` in their blocks.
  void start_rays(int left, int top, int offset, int scale, Block& block) const {
    kernels_.shaft_rays(view_, left * kBlockSide + offset, top * kBlockSide + offset, scale, block);
    kernels_.start_paths(view_, block);
  }

  void cast_shared(int left, int top, Shadows& shadows, RenderCost& cost, TaskTimer& timer) const {
    Block block;
    HitPacket hits;
    start_rays(left, top, kGroup / 2, kGroup, block);
    tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kCoherent);
    cost.shaft_rays += count(block.active);
    tracer_.locate_hits(view_, kernels_, hits, block);
    shadows.distance = block.distance;
    const auto [least, most] = std::ranges::minmax(block.distance.at);
    shadows.is_even = most <= least * (1 + 1 / kSharpness);  // also where all are infinite
    shadows.blocked = {};
    if (request_.effects.has(Effect::kShadows)) {
      kernels_.apply_water(view_, block);
      for (int k = 0; k < kSamples; ++k) {
        kernels_.shaft_sample_point(view_, sample_share(k), block);
        if (!any(block.needs_shadow_ray)) continue;
        cost.shaft_rays += count(block.needs_shadow_ray);
        tracer_.occluded(block, shadows.blocked[static_cast<std::size_t>(k)], RayOrder::kCoherent);
      }
    }
    timer.add(kShaftRays);
  }

  /// Computes the block of values at (left, top), which is at (x, y) in its group.
  void sample(int left, int top, int x, int y, const Shadows& shadows, RenderCost& cost) {
    Block block;
    std::array<std::size_t, kBlockPixels> shared;
    start_rays(left, top, kBlockSide / 2, kBlockSide, block);
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int column = (x + lane % kBlockSide) / kShare, row = (y + lane / kBlockSide) / kShare;
      shared[static_cast<std::size_t>(lane)] = static_cast<std::size_t>(row * kBlockSide + column);
      block.distance.at[lane] = shadows.distance.at[row * kBlockSide + column];
    }
    if (!shadows.is_even) {
      HitPacket hits;
      tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kCoherent);
      cost.shaft_rays += count(block.active);
      tracer_.locate_hits(view_, kernels_, hits, block);
    }
    kernels_.apply_water(view_, block);
    std::array<float, kBlockPixels> lit{}, whole{};
    for (int k = 0; k < kSamples; ++k) {
      const camera::BlockMask& blocked = shadows.blocked[static_cast<std::size_t>(k)];
      camera::BlockFloats weight, caustic;
      kernels_.shaft_sample_point(view_, sample_share(k), block);
      kernels_.shaft_sample_light(view_, block, weight, caustic);
      for (std::size_t lane = 0; lane < kBlockPixels; ++lane) {
        whole[lane] += weight.at[lane];
        lit[lane] += blocked.at[shared[lane]] ? 0.0f : weight.at[lane] * caustic.at[lane];
      }
    }
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int i = left + lane % kBlockSide, j = top + lane / kBlockSide;
      if (i >= columns_ || j >= rows_) continue;
      const auto at = static_cast<std::size_t>(j * columns_ + i);
      reach_m_[at] = std::min(block.reach.at[lane], 3 / view_.c[1]);
      if (!(whole[static_cast<std::size_t>(lane)] > 0)) continue;
      light_[at] = lit[static_cast<std::size_t>(lane)] / whole[static_cast<std::size_t>(lane)];
    }
  }

  const camera::View& view_;
  const Tracer& tracer_;
  const camera::Kernels& kernels_;
  const PictureRequest& request_;
  int columns_, rows_;
  std::vector<float> light_, reach_m_;
};

}  // namespace

ShaftImage cast_shafts(const camera::View& view, const Tracer& tracer, const camera::Kernels& kernels,
                       const PictureRequest& request, std::vector<RenderCost>& costs) {
  ShaftCaster caster(view, tracer, kernels, request);
  for_rows(caster.strips(), static_cast<int>(costs.size()),
           [&](int strip, int worker) { caster.cast(strip, costs[static_cast<std::size_t>(worker)]); });
  return std::move(caster).smoothed();
}

}  // namespace uwsim
