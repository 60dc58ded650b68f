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
constexpr int kShare = 2;                    // values across a cell
constexpr int kGroup = kShare * kBlockSide;  // across a group of 4 x 4 cells, whose rays are cast together
constexpr std::array<float, 3> kNear{0.25f, 0.5f, 0.25f};       // weights of values
constexpr std::array<float, 3> kNearCells{0.15f, 0.7f, 0.15f};  // and of cells
constexpr float kSharpness = 8;                                 // as kShaftSharpness of kernels/shafts.h

/// How alike rays are that end at two distances: 1 for the same, one half where they differ by an eighth.
float alike(float own_m, float other_m) {
  const float apart = (other_m - own_m) * kSharpness / std::max(own_m, 0.1f);
  return 1 / (1 + apart * apart * apart * apart);
}

/// Values of light for each block of pixels. Groups of 2 x 2 values, or cells, share shadow rays.
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
        group_columns_((columns_ + kGroup - 1) / kGroup),
        group_rows_((rows_ + kGroup - 1) / kGroup),
        cell_columns_(kBlockSide * group_columns_),
        cells_(static_cast<std::size_t>(cell_columns_) * static_cast<std::size_t>(kBlockSide * group_rows_)),
        blurred_(cells_.size()),
        is_even_(static_cast<std::size_t>(group_columns_) * static_cast<std::size_t>(group_rows_)),
        light_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 1.0f),
        reach_m_(light_.size(), 0.0f) {}

  /// A strip is half of a row of groups.
  int strips() const { return 2 * group_rows_; }

  void cast_shadows(int strip) {
    for_groups(strip, [&](int column, int row) { cast_shared(column, row); });
  }

  /// Each cell's shadows, mixed with those of its neighbours whose rays end about as far away: eight samples of a ray
  /// would show as many edges of each shadow.
  void blur() {
    const int cell_rows = kBlockSide * group_rows_;
    for (int y = 0; y < cell_rows; ++y) {
      for (int x = 0; x < cell_columns_; ++x) {
        const Cell& own = cell(x, y);
        Cell& out = blurred_[static_cast<std::size_t>(y * cell_columns_ + x)];
        out = {own.distance_m, own.reach_m, {}};
        float whole = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, cell_rows - 1); ++v) {
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, cell_columns_ - 1); ++u) {
            const Cell& other = cell(u, v);
            const float weight = kNearCells[v - y + 1] * kNearCells[u - x + 1] * alike(own.reach_m, other.reach_m);
            for (std::size_t k = 0; k < kSamples; ++k) out.open[k] += weight * other.open[k];
            whole += weight;
          }
        }
        for (float& open : out.open) open /= whole;
      }
    }
  }

  void cast_light(int strip) {
    for_groups(strip, [&](int column, int row) {
      for (int part = 0; part < kShare * kShare; ++part) {
        const int left = column * kGroup + part % kShare * kBlockSide, top = row * kGroup + part / kShare * kBlockSide;
        const bool even = is_even_[static_cast<std::size_t>(row * group_columns_ + column)] != 0;
        if (left < columns_ && top < rows_) sample(left, top, even);
      }
    });
  }

  /// The light, each value mixed with those of its neighbours whose rays end about as far away.
  ShaftImage smoothed() && {
    std::vector<float> out(light_.size());
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        const int here = y * columns_ + x;
        float sum = 0, whole = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, rows_ - 1); ++v) {
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, columns_ - 1); ++u) {
            const int there = v * columns_ + u;
            const float weight = kNear[v - y + 1] * kNear[u - x + 1] * alike(reach_m_[here], reach_m_[there]);
            sum += weight * light_[there], whole += weight;
          }
        }
        out[here] = sum / whole;
      }
    }
    return {std::move(out), std::move(reach_m_)};
  }

 private:
  /// Rays through the middle of 2 x 2 values: where they end, how far they count, and which of their sample points
  /// the sun reaches, 0 to 1.
  struct Cell {
    float distance_m, reach_m;
    std::array<float, kSamples> open;
  };

  const Cell& cell(int x, int y) const { return cells_[static_cast<std::size_t>(y * cell_columns_ + x)]; }
  float counted_m(float reach_m) const { return std::min(reach_m, 3 / view_.c[1]); }

  template <typename Visit>
  void for_groups(int strip, const Visit& visit) const {
    const int half = (group_columns_ + 1) / 2, first = strip % 2 == 0 ? 0 : half;
    for (int k = first; k < (strip % 2 == 0 ? half : group_columns_); ++k) visit(k, strip / 2);
  }

  static float sample_share(int k) { return (static_cast<float>(k) + 0.5f) / kSamples; }

  /// Starts paths through the pixels at `offset` in their blocks.
  void start_rays(int left, int top, int offset, int scale, Block& block) const {
    kernels_.shaft_rays(view_, left * kBlockSide + offset, top * kBlockSide + offset, scale, block);
    kernels_.start_paths(view_, block);
  }

  void cast_shared(int column, int row) {
    Block block;
    HitPacket hits;
    start_rays(column * kGroup, row * kGroup, kGroup / 2, kGroup, block);
    tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kCoherent);
    tracer_.locate_hits(view_, kernels_, hits, block);
    const auto [least, most] = std::ranges::minmax(block.distance.at);
    // Also where all are infinite
    is_even_[static_cast<std::size_t>(row * group_columns_ + column)] = most <= least * (1 + 1 / kSharpness) ? 1 : 0;
    const camera::BlockFloats distance = block.distance;
    kernels_.apply_water(view_, block);
    std::array<Cell*, kBlockPixels> own;
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int x = column * kBlockSide + lane % kBlockSide, y = row * kBlockSide + lane / kBlockSide;
      own[static_cast<std::size_t>(lane)] = &cells_[static_cast<std::size_t>(y * cell_columns_ + x)];
      *own[static_cast<std::size_t>(lane)] = {distance.at[lane], counted_m(block.reach.at[lane]), {}};
      own[static_cast<std::size_t>(lane)]->open.fill(1);
    }
    for (std::size_t k = 0; request_.effects.has(Effect::kShadows) && k < kSamples; ++k) {
      camera::BlockMask blocked{};
      kernels_.shaft_sample_point(view_, sample_share(static_cast<int>(k)), block);
      if (!any(block.needs_shadow_ray)) continue;
      tracer_.occluded(block, blocked, RayOrder::kCoherent);
      for (std::size_t lane = 0; lane < kBlockPixels; ++lane) own[lane]->open[k] = blocked.at[lane] ? 0.0f : 1.0f;
    }
  }

  /// The shadows at a value, between the nearest four cells.
  std::array<float, kSamples> open_at(int i, int j, float reach_m) const {
    const int x = i / kShare, y = j / kShare, beside = i % kShare == 0 ? -1 : 1, above = j % kShare == 0 ? -1 : 1;
    const int other_x = std::clamp(x + beside, 0, cell_columns_ - 1);
    const int other_y = std::clamp(y + above, 0, kBlockSide * group_rows_ - 1);
    std::array<float, kSamples> open{};
    float whole = 0;
    for (const auto& [column, near_x] : {std::pair(x, 0.75f), std::pair(other_x, 0.25f)}) {
      for (const auto& [row, near_y] : {std::pair(y, 0.75f), std::pair(other_y, 0.25f)}) {
        const Cell& each = blurred_[static_cast<std::size_t>(row * cell_columns_ + column)];
        const float weight = near_x * near_y * (alike(reach_m, each.reach_m) + 1e-3f);
        for (std::size_t k = 0; k < kSamples; ++k) open[k] += weight * each.open[k];
        whole += weight;
      }
    }
    for (float& each : open) each /= whole;
    return open;
  }

  /// Computes the block of values at (left, top).
  void sample(int left, int top, bool is_even) {
    Block block;
    start_rays(left, top, kBlockSide / 2, kBlockSide, block);
    for (int lane = 0; lane < kBlockPixels; ++lane)
      block.distance.at[lane] =
          cell((left + lane % kBlockSide) / kShare, (top + lane / kBlockSide) / kShare).distance_m;
    if (!is_even) {
      HitPacket hits;
      tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kCoherent);
      tracer_.locate_hits(view_, kernels_, hits, block);
    }
    kernels_.apply_water(view_, block);
    std::array<std::array<float, kSamples>, kBlockPixels> open;
    for (int lane = 0; lane < kBlockPixels; ++lane)
      open[static_cast<std::size_t>(lane)] =
          open_at(left + lane % kBlockSide, top + lane / kBlockSide, counted_m(block.reach.at[lane]));
    std::array<float, kBlockPixels> lit{}, whole{};
    for (std::size_t k = 0; k < kSamples; ++k) {
      camera::BlockFloats weight, caustic;
      kernels_.shaft_sample_point(view_, sample_share(static_cast<int>(k)), block);
      kernels_.shaft_sample_light(view_, block, weight, caustic);
      for (std::size_t lane = 0; lane < kBlockPixels; ++lane) {
        whole[lane] += weight.at[lane];
        lit[lane] += open[lane][k] * weight.at[lane] * caustic.at[lane];
      }
    }
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const int i = left + lane % kBlockSide, j = top + lane / kBlockSide;
      if (i >= columns_ || j >= rows_) continue;
      const auto at = static_cast<std::size_t>(j * columns_ + i);
      reach_m_[at] = counted_m(block.reach.at[lane]);
      if (!(whole[static_cast<std::size_t>(lane)] > 0)) continue;
      light_[at] = lit[static_cast<std::size_t>(lane)] / whole[static_cast<std::size_t>(lane)];
    }
  }

  const camera::View& view_;
  const Tracer& tracer_;
  const camera::Kernels& kernels_;
  const PictureRequest& request_;
  int columns_, rows_, group_columns_, group_rows_, cell_columns_;
  std::vector<Cell> cells_, blurred_;
  std::vector<std::uint8_t> is_even_;  // of each group: its rays end about as far away
  std::vector<float> light_, reach_m_;
};

}  // namespace

ShaftImage cast_shafts(const camera::View& view, const Tracer& tracer, const camera::Kernels& kernels,
                       const PictureRequest& request, int threads) {
  ShaftCaster caster(view, tracer, kernels, request);
  const auto for_strips = [&](auto step) {
    for_rows(caster.strips(), threads, [&](int strip, int) { (caster.*step)(strip); });
  };
  for_strips(&ShaftCaster::cast_shadows);
  caster.blur();
  for_strips(&ShaftCaster::cast_light);
  return std::move(caster).smoothed();
}

}  // namespace uwsim
