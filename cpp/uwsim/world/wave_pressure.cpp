#include <algorithm>
#include <array>
#include <cmath>

#include "uwsim/world/wave_kernels.h"
#include "uwsim/world/waves.h"

namespace uwsim {
namespace {

constexpr double kTolerance = 5e-4;     // as a fraction of the sum of the amplitudes
constexpr std::size_t kFewPoints = 16;  // for up to this many, summing the waves at each point is cheaper

void put(WaveTerms* terms, std::size_t k, double real, double imaginary, double x, double y, double z) {
  WaveTerms& at = terms[k / kWaveLanes];
  const std::size_t lane = k % kWaveLanes;
  at.real[lane] = real;
  at.imaginary[lane] = imaginary;
  at.number_x_rad_m[lane] = x;
  at.number_y_rad_m[lane] = y;
  at.decay_rad_m[lane] = z;
}

/// Pads the last block with waves of zero height; returns the number of blocks.
std::size_t blocks(WaveTerms* terms, std::size_t count) {
  while (count % kWaveLanes != 0) put(terms, count++, 0, 0, 0, 0, 0);
  return count / kWaveLanes;
}

}  // namespace

/// The lowest order of polynomial of the first `count` waves within the tolerance over `radius_m`; 0 if there is none.
int Waves::polynomial_order(double radius_m, std::size_t count) const {
  std::array<double, kHighestWaveOrder + 2> moments{};
  std::copy_n(moments_.begin(), moments.size(), moments.begin());
  for (std::size_t k = count; k < waves_.size(); ++k) {
    double moment = waves_[k].amplitude_m;
    for (double& all : moments) {
      all -= moment;
      moment *= waves_[k].number_rad_m;
    }
  }
  double scale = radius_m * radius_m / 2;
  for (std::size_t order = kLowestWaveOrder; order <= kHighestWaveOrder; ++order) {
    scale *= radius_m / static_cast<double>(order + 1);
    if (moments[order + 1] * scale <= kTolerance * moments_[0]) return static_cast<int>(order);
  }
  return 0;
}

void Waves::heads(std::span<const Eigen::Vector3d> points, double time_s, std::span<double> heads_m) const {
  int order = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::array<Crest, kMaxComponents> crests;
  double height = 0;
  std::size_t count = 0;
  if (points.size() > kFewPoints) {
    Eigen::Vector3d low = points[0], high = points[0];
    for (const Eigen::Vector3d& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    centre = 0.5 * (low + high);
    const Eigen::Vector3d half = 0.5 * (high - low);
    height = crests_at(centre.x(), centre.y(), time_s, waves_.size(), crests.data());
    const double all = significant_height_m() * significant_height_m() / 8;  // the sum of the squared amplitudes
    double slope = slope_, left_out = 0;
    for (count = waves_.size(); count > 0; --count) {
      // The stretching varies over the patch, and is greatest where the surface is lowest.
      const double change = std::min(slope * half.head<2>().norm(), 2 * bound_m_);
      const double lowest = std::min(0.0, std::max(height - change, -bound_m_)), layer = layer_m(lowest);
      const Eigen::Vector3d reach(half.x(), half.y(), layer / (layer + lowest) * (half.z() + change));
      order = polynomial_order(reach.norm(), count);
      const Wave& shortest = waves_[count - 1];
      left_out += shortest.amplitude_m * shortest.amplitude_m;
      if (order > 0 || left_out > kLeftOut * all) break;
      slope -= shortest.amplitude_m * shortest.number_rad_m;
      height -= crests[count - 1].cosine;
    }
  }
  if (order == 0) {
    for (std::size_t k = 0; k < points.size(); ++k) heads_m[k] = head_at(points[k], time_s);
    return;
  }
  const WaveKernels::Order& kernels = wave_kernels().of_order(order);
  const WavePatch patch = patch_about(centre, height, crests.data(), count, kernels);
  kernels.heads(patch, points[0].data(), points.size(), heads_m.data());
}

WavePatch Waves::patch_about(const Eigen::Vector3d& centre, double height_m, const Crest* crests, std::size_t count,
                             const WaveKernels::Order& kernels) const {
  std::array<WaveTerms, kMaxComponents / kWaveLanes> surface;
  std::array<WaveTerms, 2 * kMaxComponents / kWaveLanes> below;
  const double middle = unstretched(centre.z(), height_m);
  std::size_t flat = 0, deep = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Wave& w = waves_[k];
    const Crest& crest = crests[k];
    put(surface.data(), flat++, crest.cosine, crest.sine, w.number_x_rad_m, w.number_y_rad_m, 0);
    const double up = w.deep * std::exp(w.number_rad_m * middle);
    put(below.data(), deep++, up * crest.cosine, up * crest.sine, w.number_x_rad_m, w.number_y_rad_m, w.number_rad_m);
    if (w.deep == 1) continue;
    const double down = w.deep * std::exp(-w.number_rad_m * (middle + 2 * depth_m_));
    put(below.data(), deep++, down * crest.cosine, down * crest.sine, w.number_x_rad_m, w.number_y_rad_m,
        -w.number_rad_m);
  }
  WavePatch patch{centre.x(), centre.y(), middle, stretched_m_, kTroughs, depth_m_, {}, {}};
  kernels.fit_flat(surface.data(), blocks(surface.data(), flat), patch.surface);
  kernels.fit(below.data(), blocks(below.data(), deep), patch.below);
  return patch;
}

}  // namespace uwsim
