#include "uwsim/sonar/imaging/fan_speckle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "uwsim/core/parallel.h"
#include "uwsim/sonar/hashed_noise.h"
#include "uwsim/sonar/imaging/imaging_kernels.h"
#include "uwsim/sonar/moving_array.h"

namespace uwsim {
namespace {

/// In units of lambda / L: the distance between scatterers' bearings, less than 1, so that sums over them equal
/// integrals of a beam's power; and their farthest one from a beam's axis, the first zero of a Hamming pattern.
constexpr double kSpacing = 0.5, kFarthest = 2;

/// An orientation as a turn about the vertical, followed by a tilt about a level axis.
struct Turned {
  double twist_rad;
  Eigen::Vector2d tilt_rad;  // rotation vector

  explicit Turned(const Eigen::Quaterniond& q)
      : twist_rad(2 * std::atan2(q.z(), q.w())), tilt_rad(Eigen::Vector2d::Zero()) {
    const Eigen::AngleAxisd twist(twist_rad, Eigen::Vector3d::UnitZ());
    const Eigen::Quaterniond tilt = q * Eigen::Quaterniond(twist).conjugate();
    const Eigen::Vector2d axis = tilt.vec().head<2>();
    if (const double sine = axis.norm(); sine > 0) {
      tilt_rad = 2 * std::atan2(std::copysign(sine, tilt.w()), std::abs(tilt.w())) / sine * axis;
    }
  }
};

}  // namespace

FanSpeckle::FanSpeckle(const Beam& beam, const ImagingAcoustics& acoustics, const RandomStream& random,
                       const Pose& world_from_sonar, double low_rad, double high_rad, int threads)
    : pattern_(&beam.pattern),
      cells_(static_cast<std::size_t>(acoustics.range_bins) * static_cast<std::size_t>(acoustics.looks)) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double resolution_rad = 1 / beam.pattern.lengths_per_wave();
  around_ = static_cast<int>(std::ceil(kTurn / (kSpacing * resolution_rad)));
  spacing_rad_ = kTurn / around_;
  reach_rad_ = std::min(kFarthest * resolution_rad, std::numbers::pi / 2);
  const Turned turned(world_from_sonar.orientation);
  twist_rad_ = turned.twist_rad;
  first_ = static_cast<int>(std::ceil((twist_rad_ + low_rad - reach_rad_) / spacing_rad_));
  const int last = static_cast<int>(std::floor((twist_rad_ + high_rad + reach_rad_) / spacing_rad_));
  const auto count = static_cast<std::size_t>(std::max(0, last - first_ + 1));
  const Eigen::Vector3d moved =
      world_from_sonar.position_m / half_array_m(beam.pattern.lengths_per_wave(), acoustics.frequency_hz);
  const Eigen::Vector2d tilted = turned.tilt_rad / beam.tilt_width_rad;
  const auto key = static_cast<std::uint32_t>(mixed(random.key() + random.stream()));
  const SimplexNodes<5> nodes = simplex_nodes<5>({moved.x(), moved.y(), moved.z(), tilted.x(), tilted.y()}, key);
  amplitudes_.resize(count * cells_);  // left uninitialised
  if (cells_ == 0) return;
  parallel_ranges(
      count, threads,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) fill(k, nodes);
      },
      1);
}

void FanSpeckle::fill(std::size_t scatterer, const SimplexNodes<5>& nodes) {
  const int bearing = ((first_ + static_cast<int>(scatterer)) % around_ + around_) % around_;
  Amplitude* const row = amplitudes_.data() + scatterer * cells_;
  const float scale = 1 / std::sqrt(2 * kByteSumVariance);
  std::array<std::uint32_t, 6> keys;
  std::array<float, keys.size()> weights;
  for (std::size_t node = 0; node < keys.size(); ++node) {
    keys[node] = mixed(nodes.keys[node] + 0x9e3779b1U * static_cast<std::uint32_t>(bearing));
    weights[node] = scale * nodes.weights[node];
  }
  imaging_kernels().noise(keys.data(), weights.data(), keys.size(), cells_, reinterpret_cast<float*>(row));
}

std::span<const FanSpeckle::Amplitude> FanSpeckle::of_beam(double bearing_rad, std::vector<Amplitude>& row) const {
  row.resize(cells_);
  if (cells_ == 0) return row;
  const double axis_rad = twist_rad_ + bearing_rad;
  const int last = first_ + static_cast<int>(amplitudes_.size() / cells_) - 1;
  const int near = std::max(first_, static_cast<int>(std::ceil((axis_rad - reach_rad_) / spacing_rad_)));
  const int far = std::min(last, static_cast<int>(std::floor((axis_rad + reach_rad_) / spacing_rad_)));
  std::vector<double> pattern;
  double squares = 0;
  for (int k = near; k <= far; ++k) {
    pattern.push_back(pattern_->amplitude_at(k * spacing_rad_ - axis_rad));
    squares += pattern.back() * pattern.back();
  }
  std::vector<float> weights;
  for (const double amplitude : pattern) weights.push_back(static_cast<float>(amplitude / std::sqrt(squares)));
  const Amplitude* const from = amplitudes_.data() + static_cast<std::size_t>(near - first_) * cells_;
  imaging_kernels().sum_rows(reinterpret_cast<const float*>(from), weights.data(), weights.size(), 2 * cells_,
                             reinterpret_cast<float*>(row.data()));
  return row;
}

}  // namespace uwsim
