#include "uwsim/sonar/speckle_field.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "uwsim/sonar/beam_kernels.h"
#include "uwsim/sonar/hashed_noise.h"
#include "uwsim/sonar/moving_array.h"

namespace uwsim {
namespace {

constexpr std::size_t kSpline = 2;           // number of cells under a linear B-spline
constexpr std::size_t kCells = 2 * kSpline;  // including both sizes
constexpr double kRounding = 16;             // resolution of the lattices' orientation: 1/16 of a unit quaternion
constexpr float kMidway = 0.27f;
// Cell width at which the B-spline alone has the curvature of the footprint.
const double kCellPerDeviation = std::sqrt(6.0);
constexpr double kLeast_m = 1e-4;
// The hash keys of cells (i, j) are the sums of i and j times these; no two cells within some 10^4 of each other share
// a key.
constexpr std::uint32_t kStrideAcross = 0x9e3779b1U, kStrideWithin = 0x85ebca77U;

constexpr double kLineArray = 0.886;  // length in wave lengths times the beam's width at -3 dB
/// A draw makes an intensity, whose correlation is the square of the amplitudes': (1 - d)^2 for a line array.
constexpr double kIntensity = 0.7;

/// A power of two [m]; `level` must be within the exponent range of a double.
double power_of_two(int level) { return std::bit_cast<double>(static_cast<std::uint64_t>(level + 1023) << 52); }

/// The cells along one axis that a footprint covers: weights and keys of two cells of one size and of two cells of
/// twice that size.
struct CoveredCells {
  alignas(16) std::array<float, kCells> weight{};
  alignas(16) std::array<std::uint32_t, kCells> number{};
  float squares = 0;  // the sum of the squared weights

  /// A linear B-spline on cells of size c has a correlation of about exp(-1.5 d^2 / c^2). Mixing the two sizes in the
  /// proportion `by_curvature` would match the curvature of a Gaussian footprint's correlation at d = 0; kMidway is
  /// chosen for the best agreement up to a d of two deviations. `stride`: odd; keys are its multiples, starting at a
  /// value that depends on the level.
  CoveredCells(double at_m, float deviation_m, std::uint32_t stride, const SpeckleField::LevelKeys& keys) {
    const auto bits = std::bit_cast<std::uint64_t>(kCellPerDeviation * std::max<double>(deviation_m, kLeast_m));
    // The size of the largest cells that are fine enough is 2^level
    const int level = static_cast<int>(bits >> 52) - 1023;
    const auto ratio = std::bit_cast<double>((bits & kMantissa) | kOne);
    // Square of the ratio of the finer size to the footprint's: in (1/4, 1]
    const auto square = static_cast<float>(1 / (ratio * ratio));
    const float by_curvature = (square - 0.25f) / 0.75f;
    const float fine = by_curvature + kMidway * by_curvature * (1 - by_curvature);
    cover(0, at_m, level, std::sqrt(fine), stride, keys);
    cover(kSpline, at_m, level + 1, std::sqrt(1 - fine), stride, keys);
  }

 private:
  static constexpr std::uint64_t kMantissa = (1ULL << 52) - 1, kOne = 1023ULL << 52;

  void cover(std::size_t first, double at_m, int level, float share, std::uint32_t stride,
             const SpeckleField::LevelKeys& keys) {
    const double cells = at_m * power_of_two(-level);
    auto cell = static_cast<std::int64_t>(cells);
    cell -= static_cast<double>(cell) > cells;  // rounds down
    const auto off = static_cast<float>(cells - static_cast<double>(cell));
    const std::array<float, kSpline> weights = {share * (1 - off), share * off};
    const std::uint32_t start = keys[static_cast<std::size_t>(level) % keys.size()];
    for (std::size_t k = 0; k < kSpline; ++k) {
      weight[first + k] = weights[k];
      squares += weights[k] * weights[k];
      number[first + k] = start + stride * (static_cast<std::uint32_t>(cell) + static_cast<std::uint32_t>(k));
    }
  }
};

}  // namespace

EchoFootprint echo_footprint(std::span<const RayEcho> rays, const Eigen::Ref<const Eigen::Matrix3Xf>& directions) {
  const Eigen::Vector3f base = rays.front().range_m * directions.col(rays.front().ray);
  Eigen::Array3f sum = Eigen::Array3f::Zero(), squares = Eigen::Array3f::Zero();
  for (const RayEcho& ray : rays) {  // differences from the nearest hit preserve the precision of float
    const Eigen::Array3f off = ray.range_m * directions.col(ray.ray) - base;
    sum += off;
    squares += off.square();
  }
  const float share = 1 / static_cast<float>(rays.size());
  const Eigen::Array3f mean = sum * share;
  return {base + mean.matrix(), (squares * share - mean.square()).max(0.0f).sqrt().matrix()};
}

SpeckleField::SpeckleField(std::uint64_t seed, const SonarParameters& parameters)
    : key_(mixed(seed ^ mixed(std::bit_cast<std::uint64_t>(parameters.frequency_hz)))) {
  for (std::size_t level = 0; level < across_.size(); ++level) {
    across_[level] = static_cast<std::uint32_t>(mixed(key_ + level));
    within_[level] = static_cast<std::uint32_t>(mixed(key_ + level) >> 32);
  }
  const double within_m = half_array_m(kLineArray / parameters.beam_width_across_rad, parameters.frequency_hz);
  const double across_m = half_array_m(kLineArray / parameters.beam_width_along_rad, parameters.frequency_hz);
  nodes_m_ = kIntensity * Eigen::Vector3d(std::max(within_m, across_m), within_m, across_m);
}

SpeckleField::View SpeckleField::view(const Pose& world_from_sonar) const {
  Eigen::Vector4d rounded = world_from_sonar.orientation.coeffs();
  // Both signs of a quaternion represent the same orientation. The sign flips where heads are unlikely to be mounted.
  if (rounded.dot(Eigen::Vector4d(0.37, 0.29, 0.59, 0.66)) < 0) rounded = -rounded;
  View view;
  view.field_ = this;
  std::uint64_t key = key_;
  for (double& part : rounded) {
    part = std::round(kRounding * part);
    key = mixed(key + static_cast<std::uint64_t>(static_cast<std::int64_t>(part)));
  }
  const Eigen::Matrix3d lattice_from_world = Eigen::Quaterniond(rounded).normalized().toRotationMatrix().transpose();
  view.head_m_ = lattice_from_world * world_from_sonar.position_m;
  view.lattice_from_sonar_ = lattice_from_world * world_from_sonar.rotation();
  const Eigen::Vector3d moved = view.head_m_.cwiseQuotient(nodes_m_);
  view.nodes_ = simplex_nodes<3>({moved.x(), moved.y(), moved.z()}, static_cast<std::uint32_t>(key));
  return view;
}

std::array<double, 2> SpeckleField::View::draws(const EchoFootprint& footprint) const {
  const Eigen::Vector3d at_m = head_m_ + lattice_from_sonar_ * footprint.middle_m.cast<double>();
  const Eigen::Vector3f& deviation_m = footprint.deviation_m;
  // Within the fan's plane, cells lie along the axis to which the surface is closer to parallel.
  const Eigen::Index along = deviation_m.y() >= deviation_m.x() ? 1 : 0;
  const CoveredCells within(at_m[along], deviation_m[along], kStrideWithin, field_->within_);
  const CoveredCells across(at_m.z(), deviation_m.z(), kStrideAcross, field_->across_);
  std::array<std::uint32_t, 4> keys;
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = nodes_.keys[k] + static_cast<std::uint32_t>(along);
  std::array<float, 4> one, two;
  static const BeamKernels& kernels = beam_kernels();
  kernels.noise({across.number.data(), across.weight.data(), within.number.data(), within.weight.data(), keys.data()},
                one.data(), two.data());
  const float scale = 1 / std::sqrt(kByteSumVariance * across.squares * within.squares);
  std::array<double, 2> sums = {0, 0};
  for (std::size_t k = 0; k < keys.size(); ++k) {
    sums[0] += nodes_.weights[k] * double{one[k] * scale};
    sums[1] += nodes_.weights[k] * double{two[k] * scale};
  }
  return sums;
}

}  // namespace uwsim
