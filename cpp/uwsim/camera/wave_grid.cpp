#include "uwsim/camera/wave_grid.h"

#include <array>
#include <cmath>
#include <complex>

#include "uwsim/camera/parallel_rows.h"

namespace uwsim {
namespace {

constexpr int kSide = WaveGrid::kSide;
using Phasor = std::complex<double>;
using Row = std::array<double, kSide>;

/// A wave along a row of nodes: its phasor at the row's first node, and the rotations to apply to it.
struct WaveTrain {
  WaveComponent wave;
  double kx, ky;
  Row cosine, sine;
};

WaveTrain wave_train(const WaveComponent& wave, const Water& water, double spacing_m) {
  const double k = wave_number_rad_m(wave.angular_frequency_rad_s, water.waves->depth_m(), water.gravity_m_s2);
  WaveTrain train{wave, k * std::cos(wave.heading_rad), k * std::sin(wave.heading_rad), {}, {}};
  for (int i = 0; i < kSide; ++i) {
    train.cosine[i] = std::cos(train.kx * spacing_m * i);
    train.sine[i] = std::sin(train.kx * spacing_m * i);
  }
  return train;
}

/// Computes heights and slopes along the row at y_m, starting at west_m: [node][height, slope x, slope y].
void sum_row(const std::vector<WaveTrain>& trains, double west_m, double y_m, double time_s, float* values) {
  Row height{}, slope_x{}, slope_y{};
  for (const WaveTrain& train : trains) {
    const WaveComponent& wave = train.wave;
    const Phasor first = std::polar(
        wave.amplitude_m, train.kx * west_m + train.ky * y_m - wave.angular_frequency_rad_s * time_s + wave.phase_rad);
    const double c = first.real(), s = first.imag();
    for (int i = 0; i < kSide; ++i) {
      const double across = s * train.cosine[i] + c * train.sine[i];
      height[i] += c * train.cosine[i] - s * train.sine[i];
      slope_x[i] -= train.kx * across;
      slope_y[i] -= train.ky * across;
    }
  }
  for (int i = 0; i < kSide; ++i, values += 3) {
    values[0] = static_cast<float>(height[i]);
    values[1] = static_cast<float>(slope_x[i]);
    values[2] = static_cast<float>(slope_y[i]);
  }
}

}  // namespace

WaveGrid::WaveGrid(const Water& water, const Eigen::Vector3d& centre, double time_s, int threads) {
  if (!water.waves) return;
  const double west = (std::floor(centre.x() / kSpacing_m) - kSide / 2) * kSpacing_m;
  const double south = (std::floor(centre.y() / kSpacing_m) - kSide / 2) * kSpacing_m;
  left_m_ = west - centre.x();
  bottom_m_ = south - centre.y();
  std::vector<WaveTrain> trains;
  for (const WaveComponent& wave : water.waves->components()) trains.push_back(wave_train(wave, water, kSpacing_m));
  values_.resize(3 * kSide * kSide);
  for_rows(kSide, threads,
           [&](int j, int) { sum_row(trains, west, south + j * kSpacing_m, time_s, values_.data() + 3 * j * kSide); });
}

camera::WaveNodes WaveGrid::nodes() const {
  return {values_.empty() ? nullptr : values_.data(), kSide, static_cast<float>(kSpacing_m),
          static_cast<float>(left_m_), static_cast<float>(bottom_m_)};
}

}  // namespace uwsim
