#include "uwsim/world/waves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

// Depth, in units of 1 / k, below which less than 2e-7 of a wave's motion remains.
constexpr double kDepthOfMotion = 15.5;
constexpr double kDepthOfMainMotion = 7;  // less than 1e-3

}  // namespace

double wave_number_rad_m(double omega, double depth_m, double gravity_m_s2) {
  const double deep = omega * omega / gravity_m_s2;
  if (!std::isfinite(depth_m)) return deep;
  double kh = deep * depth_m;
  kh = kh < 1 ? std::sqrt(kh) : kh;
  for (int k = 0; k < 50; ++k) {  // Newton's method on kh tanh(kh) = omega^2 h / g, which is monotone and convex here
    const double t = std::tanh(kh);
    const double step = (kh * t - deep * depth_m) / (t + kh * (1 - t * t));
    kh -= step;
    if (std::abs(step) < 1e-15 * kh) break;
  }
  return kh / depth_m;
}

Waves::Waves(std::span<const WaveComponent> components, double depth_m, double gravity_m_s2)
    : depth_m_(depth_m), gravity_m_s2_(gravity_m_s2) {
  require(!components.empty() && components.size() <= kMaxComponents, "water.surface.components", components.size(),
          "must be 1 to 512 components");
  require(depth_m > 0.1, "water.surface.depth_m", depth_m, "must be more than 0.1 m");
  require(gravity_m_s2 > 0, "water.gravity_m_s2", gravity_m_s2, "must be positive where there are waves");
  for (const WaveComponent& c : components) {
    require(c.amplitude_m >= 0 && c.amplitude_m <= 20, "water.surface.amplitude_m", c.amplitude_m,
            "must be in [0, 20] m");
    require(c.angular_frequency_rad_s >= 0.05 && c.angular_frequency_rad_s <= 50,
            "water.surface.angular_frequency_rad_s", c.angular_frequency_rad_s, "must be in [0.05, 50] rad/s");
    require(std::isfinite(c.heading_rad) && std::isfinite(c.phase_rad), "water.surface.heading_rad", c.heading_rad,
            "must be finite");
    const double k = wave_number_rad_m(c.angular_frequency_rad_s, depth_m, gravity_m_s2);
    require(c.amplitude_m * k <= kSteepest, "water.surface.amplitude_m", with_unit(c.amplitude_m, "m"),
            "the wave would break: amplitude times wave number must be at most 0.45");
    require(c.amplitude_m < 0.5 * depth_m, "water.surface.amplitude_m", with_unit(c.amplitude_m, "m"),
            "must be less than half the depth of the water");
    waves_.push_back({c.amplitude_m, c.angular_frequency_rad_s, k, k * std::cos(c.heading_rad),
                      k * std::sin(c.heading_rad), c.phase_rad, 1 / (1 + std::exp(-2 * k * depth_m)),
                      1 / std::tanh(k * depth_m)});
    bound_m_ += c.amplitude_m;
    slope_ += c.amplitude_m * k;
  }
  std::stable_sort(waves_.begin(), waves_.end(),
                   [](const Wave& a, const Wave& b) { return a.number_rad_m < b.number_rad_m; });
  put_into_blocks();
  require(bound_m_ < depth_m, "water.surface", with_unit(bound_m_, "m, the sum of the amplitudes"),
          "must be less than the depth");
  stretched_m_ = std::min(0.5 * significant_height_m(), depth_m_);
  double left_out = 0;
  for (auto wave = waves_.rbegin(); wave != waves_.rend(); ++wave) {
    resolved_rad_m_ = wave->number_rad_m;
    left_out += wave->amplitude_m * wave->amplitude_m;
    if (left_out > kLeftOut * significant_height_m() * significant_height_m() / 8) break;
  }
}

double Waves::significant_height_m() const {
  double variance = 0;
  for (const Wave& w : waves_) variance += 0.5 * w.amplitude_m * w.amplitude_m;
  return 4 * std::sqrt(variance);
}

std::vector<WaveComponent> Waves::components() const {
  std::vector<WaveComponent> out;
  for (const Wave& w : waves_) {
    out.push_back({w.amplitude_m, w.omega_rad_s, std::atan2(w.number_y_rad_m, w.number_x_rad_m), w.phase_rad});
  }
  return out;
}

void Waves::put_into_blocks() {
  blocks_.resize((waves_.size() + WaveBlock::kLanes - 1) / WaveBlock::kLanes);
  for (std::size_t k = 0; k < waves_.size(); ++k) {
    const Wave& w = waves_[k];
    WaveBlock& block = blocks_[k / WaveBlock::kLanes];
    const std::size_t lane = k % WaveBlock::kLanes;
    block.amplitude_m[lane] = w.amplitude_m;
    block.omega_rad_s[lane] = w.omega_rad_s;
    block.period_s_rad[lane] = 1 / w.omega_rad_s;
    block.number_rad_m[lane] = w.number_rad_m;
    block.number_x_rad_m[lane] = w.number_x_rad_m;
    block.number_y_rad_m[lane] = w.number_y_rad_m;
    block.phase_rad[lane] = w.phase_rad;
    block.deep[lane] = w.deep;
    block.rise_rad_s[lane] = w.omega_rad_s * w.shallow;
    block.along_m_s[lane] = w.omega_rad_s * w.shallow / w.number_rad_m;
    block.mirror[lane] = w.deep < 1 ? w.deep * std::exp(-2 * w.number_rad_m * depth_m_) : 0;
    block.most_rad_m = w.number_rad_m;  // the last is the shortest
  }
}

std::size_t Waves::count_reaching(double z_m) const { return count_reaching(z_m, kDepthOfMotion); }

std::size_t Waves::count_reaching(double z_m, double depths) const {
  if (z_m > -kTroughs * bound_m_) return blocks_.size();  // within the stretched layer of the deepest trough
  const double limit = depths / -z_m;
  const auto end =
      std::partition_point(waves_.begin(), waves_.end(), [limit](const Wave& w) { return w.number_rad_m < limit; });
  return (static_cast<std::size_t>(end - waves_.begin()) + WaveBlock::kLanes - 1) / WaveBlock::kLanes;
}

/// Computes the crests of the first `count` blocks; returns the surface's height, which is the sum of their cosines.
double Waves::crests_at(double x, double y, double time_s, std::size_t count, Crests& crests) const {
  double height = 0;
  if (wave_sum_kernels().crests(blocks_.data(), count, x, y, time_s, crests.data(), height)) return height;
  height = 0;
  for (std::size_t k = 0; k < count * WaveBlock::kLanes; ++k) {
    const WaveBlock& w = blocks_[k / WaveBlock::kLanes];
    const std::size_t lane = k % WaveBlock::kLanes;
    const double phase =
        w.number_x_rad_m[lane] * x + w.number_y_rad_m[lane] * y - w.omega_rad_s[lane] * time_s + w.phase_rad[lane];
    CrestBlock& crest = crests[k / WaveBlock::kLanes];
    crest.cosine_m[lane] = w.amplitude_m[lane] * std::cos(phase);
    crest.sine_m[lane] = w.amplitude_m[lane] * std::sin(phase);
    height += crest.cosine_m[lane];
  }
  return height;
}

double Waves::layer_m(double height_m) const {
  return std::min(std::max(stretched_m_, -kTroughs * height_m), depth_m_);
}

/// Above the surface, z_m is 0.
Waves::Stretched Waves::stretched(double z_m, double height_m) const {
  if (z_m > height_m) return {0, 0, 0};
  const double layer = layer_m(height_m);
  if (z_m <= -layer) return {std::max(z_m, -depth_m_), 1, 0};
  const double under = layer + height_m, factor = layer / under;
  // The depth of the layer either follows that of the trough or is constant.
  const bool deepens = layer > stretched_m_ && layer < depth_m_;
  return {factor * (z_m - height_m), factor, deepens ? -factor : -factor * (layer + z_m) / under};
}

double Waves::height_at(double x, double y, double time_s) const {
  Crests crests;
  return crests_at(x, y, time_s, blocks_.size(), crests);
}

WaterSurface Waves::surface_over(const SurfaceArea& area, double time_s) const {
  Crests crests;
  const double height = crests_at(area.x_world_m, area.y_world_m, time_s, blocks_.size(), crests),
               change = slope_ * area.radius_m;
  WaveSurfaceSums sums;
  wave_sum_kernels().surface(blocks_.data(), blocks_.size(), crests.data(), area.spread_m2.data(), sums);
  return {std::max(-bound_m_, height - change), std::min(bound_m_, height + change), sums.mean_m, sums.slope_x,
          sums.slope_y};
}

double Waves::head_at(const Eigen::Vector3d& p, double time_s) const {
  const std::size_t count = count_reaching(p.z());
  if (count == 0) return -p.z();
  Crests crests;
  const double height = crests_at(p.x(), p.y(), time_s, count, crests);
  if (p.z() >= height) return height - p.z();
  const double z = unstretched(p.z(), height);
  double head = -p.z();
  for (std::size_t k = 0; k < std::min(count * WaveBlock::kLanes, waves_.size()); ++k) {
    const Wave& w = waves_[k];
    double decay = w.deep * std::exp(w.number_rad_m * z);
    if (w.deep < 1) decay += w.deep * std::exp(-w.number_rad_m * (z + 2 * depth_m_));
    head += crests[k / WaveBlock::kLanes].cosine_m[k % WaveBlock::kLanes] * decay;
  }
  return head;
}

/// Uses the surface eta, its derivatives, and the velocity gradient. The gradient is symmetric and trace-free, because
/// the flow of linear theory has neither rotation nor divergence. A particle at z' has the velocity that linear theory
/// predicts at z(z', eta), so its acceleration is du/dt + u du/dx + v du/dy + Dz/Dt du/dz, where Dz/Dt follows from the
/// chain rule.
Eigen::Vector3d Waves::convective(const WaveMotionSums& sums, const Stretched& at, const Eigen::Vector3d& current_m_s) {
  // derivatives of eta with respect to x, y and t
  const Eigen::Vector3d surface(Eigen::Map<const Eigen::Vector3d>(sums.surface));
  const auto& [xx, xy, yy, xz, yz] = sums.gradient;
  const Eigen::Vector3d carried = Eigen::Map<const Eigen::Vector3d>(sums.velocity_m_s) + current_m_s;
  const double surface_rises = surface.z() + carried.x() * surface.x() + carried.y() * surface.y();
  const double rises = at.by_point * carried.z() + at.by_surface * surface_rises;
  return carried.x() * Eigen::Vector3d(xx, xy, xz) + carried.y() * Eigen::Vector3d(xy, yy, yz) +
         rises * Eigen::Vector3d(xz, yz, -xx - yy);
}

WaveMotion Waves::motion_at(const Eigen::Vector3d& p, double time_s, const Eigen::Vector3d& current_m_s) const {
  const std::size_t count = count_reaching(p.z());
  if (count == 0) return {};
  Crests crests;
  const double height = crests_at(p.x(), p.y(), time_s, count, crests);
  return motion_of(crests, height, count, p, current_m_s);
}

WaveMotion Waves::motion_of(const Crests& crests, double height, std::size_t count, const Eigen::Vector3d& p,
                            const Eigen::Vector3d& current_m_s) const {
  const Stretched at = stretched(p.z(), height);
  WaveMotionSums sums;
  wave_sum_kernels().motion(blocks_.data(), count, crests.data(), at.z_m, sums);
  const double fade = at.z_m < 0 ? std::min((height - p.z()) / (layer_m(height) + height), 1.0) : 0;
  return {Eigen::Vector3d(sums.velocity_m_s), Eigen::Vector3d(sums.local_m_s2), convective(sums, at, current_m_s),
          fade};
}

void Waves::add_flow(const Eigen::Vector3d& p, double time_s, WaterFlow& flow) const {
  const WaveMotion motion = motion_at(p, time_s, flow.velocity_m_s);
  flow.velocity_m_s += motion.velocity_m_s;
  flow.wave_acceleration_m_s2 += motion.local_m_s2 + motion.convective_m_s2;
}

void Waves::add_main_flow(const Eigen::Vector3d& p, double time_s, WaterFlow& flow, double emerged_m,
                          double* surface_m) const {
  const std::size_t moving = count_reaching(p.z(), kDepthOfMainMotion);
  const std::size_t count = surface_m != nullptr ? blocks_.size() : moving;
  Crests crests;
  const double height = count == 0 ? 0 : crests_at(p.x(), p.y(), time_s, count, crests);
  if (surface_m != nullptr) {
    *surface_m = height;
    if (p.z() - height >= emerged_m) return;
  }
  if (moving == 0) return;
  const WaveMotion motion = motion_of(crests, height, moving, p, flow.velocity_m_s);
  flow.velocity_m_s += motion.velocity_m_s;
  flow.wave_acceleration_m_s2 += motion.local_m_s2 + motion.convective_m_s2;
}

double Waves::bernoulli_head_at(const Eigen::Vector3d& p, double time_s) const {
  const WaveMotion motion = motion_at(p, time_s, Eigen::Vector3d::Zero());
  return -motion.fade * motion.velocity_m_s.squaredNorm() / (2 * gravity_m_s2_);
}

}  // namespace uwsim
