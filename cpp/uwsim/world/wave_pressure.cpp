#include <algorithm>
#include <array>
#include <cmath>

#include "uwsim/world/wave_polynomial.h"
#include "uwsim/world/waves.h"

namespace uwsim {
namespace {

constexpr double kTolerance = 5e-4;     // of the sum of the amplitudes
constexpr std::size_t kFewPoints = 16;  // up to these, summing the waves at each point is cheaper

}  // namespace

/// The lowest order of polynomial that keeps the tolerance within `radius_m`; 0 when none does.
int Waves::polynomial_order(double radius_m) const {
  double scale = radius_m * radius_m / 2;
  for (std::size_t order = 2; order <= 9; ++order) {
    scale *= radius_m / static_cast<double>(order + 1);
    if (moments_[order + 1] * scale <= kTolerance * moments_[0]) return static_cast<int>(order);
  }
  return 0;
}

void Waves::heads(std::span<const Eigen::Vector3d> points, double time_s, std::span<double> heads_m) const {
  int order = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::array<Crest, kMaxComponents> crests;
  double height = 0;
  if (points.size() > kFewPoints) {
    Eigen::Vector3d low = points[0], high = points[0];
    for (const Eigen::Vector3d& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    centre = 0.5 * (low + high);
    Eigen::Vector3d reach = 0.5 * (high - low);
    height = crests_at(centre.x(), centre.y(), time_s, waves_.size(), crests.data());
    // The stretching varies over the patch, and is largest where the surface is lowest.
    const double change = std::min(slope_ * reach.head<2>().norm(), 2 * bound_m_);
    const double lowest = std::min(0.0, std::max(height - change, -bound_m_)), layer = layer_m(lowest);
    reach.z() = layer / (layer + lowest) * (reach.z() + change);
    order = polynomial_order(reach.norm());
  }
  switch (order) {
    case 2:
      return polynomial_heads<2>(points, centre, height, crests.data(), heads_m);
    case 3:
      return polynomial_heads<3>(points, centre, height, crests.data(), heads_m);
    case 4:
      return polynomial_heads<4>(points, centre, height, crests.data(), heads_m);
    case 5:
      return polynomial_heads<5>(points, centre, height, crests.data(), heads_m);
    case 6:
      return polynomial_heads<6>(points, centre, height, crests.data(), heads_m);
    case 7:
      return polynomial_heads<7>(points, centre, height, crests.data(), heads_m);
    case 8:
      return polynomial_heads<8>(points, centre, height, crests.data(), heads_m);
    case 9:
      return polynomial_heads<9>(points, centre, height, crests.data(), heads_m);
    default:
      for (std::size_t k = 0; k < points.size(); ++k) heads_m[k] = head_at(points[k], time_s);
  }
}

template <int kOrder>
void Waves::polynomial_heads(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre, double height_m,
                             const Crest* crests, std::span<double> heads_m) const {
  std::array<WaveTerm, kMaxComponents> flat;
  std::array<WaveTerm, 2 * kMaxComponents> deep;
  const double middle = unstretched(centre.z(), height_m);
  std::size_t count = 0;
  for (std::size_t k = 0; k < waves_.size(); ++k) {
    const Wave& w = waves_[k];
    const Crest& crest = crests[k];
    flat[k] = {crest.cosine, crest.sine, w.number_x_rad_m, w.number_y_rad_m, 0};
    const double up = w.deep * std::exp(w.number_rad_m * middle);
    deep[count++] = {up * crest.cosine, up * crest.sine, w.number_x_rad_m, w.number_y_rad_m, w.number_rad_m};
    if (w.deep == 1) continue;
    const double down = w.deep * std::exp(-w.number_rad_m * (middle + 2 * depth_m_));
    deep[count++] = {down * crest.cosine, down * crest.sine, w.number_x_rad_m, w.number_y_rad_m, -w.number_rad_m};
  }
  const WavePolynomial<kOrder> surface(std::span(flat.data(), waves_.size())), below(std::span(deep.data(), count));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d& p = points[k];
    const double x = p.x() - centre.x(), y = p.y() - centre.y();
    const double top = surface.flat_at(x, y);
    heads_m[k] = (p.z() >= top ? top : below.at(x, y, unstretched(p.z(), top) - middle)) - p.z();
  }
}

}  // namespace uwsim
