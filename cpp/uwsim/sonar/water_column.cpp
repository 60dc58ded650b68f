#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "uwsim/sonar/acoustic_transmission.h"
#include "uwsim/sonar/beam_kernels.h"
#include "uwsim/sonar/hashed_noise.h"

// The water as received by a multibeam: targets, volume reverberation, and every sample of a beam's echo.
namespace uwsim {
namespace {

constexpr double kFaint = 1e-6;  // of the beam's pattern, below which a target is not received
constexpr float kShapeReach = 15.0f / 16;
constexpr std::size_t kLanes = 16;  // samples of a kernel

}  // namespace

/// Point targets by the sonar equation: the pattern x 10^(TS / 10) / R^4 10^(-2 alpha R / 10) of the source's
/// intensity.
void AcousticMultibeam::add_targets(const Transmission& sent, double time_s, OtherEchoes& others) const {
  const Eigen::Vector3d& head = sent.world_from_sonar.position_m;
  RayPacket packet{};
  std::array<Eigen::Vector3d, kPacketRays> places;
  std::array<double, kPacketRays> sections_m2{};
  std::size_t count = 0;
  const auto receive = [&] {
    Blocked blocked{};
    sent.scene.occluded(head, packet, blocked);
    for (std::size_t lane = 0; lane < count; ++lane) {
      if (blocked[lane] != 0) continue;
      const double range_m = places[lane].norm();
      const Eigen::Vector3d direction = sent.rotation.transpose().cast<double>() * places[lane] / range_m;
      const double within_rad = std::atan2(direction.y(), direction.x());
      const double aside = transmitted(within_rad, std::asin(std::clamp(direction.z(), -1.0, 1.0)));
      const double depth_m = -(head.z() + places[lane].z());
      const double on_axis = aside * sections_m2[lane] * lost(sent, depth_m, 2 * range_m) / std::pow(range_m, 4);
      for (std::size_t beam = 0; beam < others.size(); ++beam) {
        const double pattern = received(beam, within_rad);
        if (pattern * aside < kFaint) continue;
        RayEcho echo;
        echo.range_m = static_cast<float>(range_m);
        echo.energy = static_cast<float>(pattern * on_axis);
        echo.width_m = sent.cell_m;
        echo.point_m2 = sent.cell_m * sent.cell_m;
        echo.cosine = 1;
        if (echo.energy > 0) others[beam].push_back(echo);
      }
    }
    packet = RayPacket{};
    count = 0;
  };
  for (const MovingTargets& group : targets_) {
    const Eigen::Matrix3Xd places_world_m = group.at(time_s);
    for (Eigen::Index k = 0; k < places_world_m.cols(); ++k) {
      const Eigen::Vector3d place_m = places_world_m.col(k) - head;
      const double range_m = place_m.norm();
      if (places_world_m(2, k) > 0 || !(range_m > 0.01 && range_m < fan_.range_max_m)) continue;
      const Eigen::Vector3d direction = sent.rotation.transpose().cast<double>() * place_m / range_m;
      const double aside_rad = std::asin(std::clamp(direction.z(), -1.0, 1.0));
      if (transmitted(std::atan2(direction.y(), direction.x()), aside_rad) < kFaint) continue;
      places[count] = place_m;
      sections_m2[count] = group.cross_section_m2();
      packet.direction_x[count] = static_cast<float>(place_m.x() / range_m);
      packet.direction_y[count] = static_cast<float>(place_m.y() / range_m);
      packet.direction_z[count] = static_cast<float>(place_m.z() / range_m);
      packet.far_m[count] = static_cast<float>(range_m);
      packet.active[count] = -1;
      if (++count == kPacketRays) receive();
    }
  }
  if (count > 0) receive();
}

/// The volume's echo from a range cell at 1 m without losses, as a ratio of the source's intensity.
double AcousticMultibeam::volume_at_1m(const Transmission& sent, std::size_t beam) const {
  return volume_strength_ * spec_.parameters.beam_solid_angle_sr() * footprint_.widening(beam) * sent.cell_m;
}

/// The volume's echo from one range cell, as a ratio of the source's intensity.
double AcousticMultibeam::reverberation(const Transmission& sent, std::size_t beam, double range_m) const {
  if (volume_strength_ == 0) return 0;
  const double range = std::max(range_m, 0.01);
  const Eigen::Vector3f axis_world = sent.rotation * footprint_.axes().col(static_cast<Eigen::Index>(beam));
  const double depth_m = std::max(0.0, sent.depth_m - range * axis_world.z());
  return volume_at_1m(sent, beam) / (range * range) * lost(sent, depth_m, 2 * range);
}

double AcousticMultibeam::background(const Transmission& sent, std::size_t beam, double range_m) const {
  return footprint_.widening(beam) + detector_.system_ratio() * reverberation(sent, beam, range_m);
}

void AcousticMultibeam::record_water_column(const Transmission& sent, std::size_t beam,
                                            std::span<const RayEcho> surface, std::span<const RayEcho> others,
                                            AcousticPing& ping) const {
  const double sample_m = ping.water_column_sample_m;
  std::vector<float> power((sent.samples + kLanes - 1) / kLanes * kLanes, 0.0f);
  // Each echo keeps its energy: its shape is that of RayEcho, at least as wide as a sample, divided by its sum.
  const auto add = [&](const RayEcho& echo) {
    const double half_m = kShapeReach * std::max(double{echo.width_m}, sample_m);
    const auto shape = [&](double k) {
      const double off = ((k + 0.5) * sample_m - echo.range_m) / half_m;
      return std::abs(off) < 1 ? (1 - off * off) * (1 - off * off) : 0.0;
    };
    const double from = std::ceil((echo.range_m - half_m) / sample_m - 0.5);
    const double to = std::floor((echo.range_m + half_m) / sample_m - 0.5);
    double sum = 0;
    for (double k = from; k <= to; ++k) sum += shape(k);
    const double end = std::min(to, static_cast<double>(sent.samples) - 1);
    for (double k = std::max(from, 0.0); k <= end && sum > 0; ++k) {
      power[static_cast<std::size_t>(k)] += static_cast<float>(shape(k) / sum * echo.energy * sent.cell_m / sample_m);
    }
  };
  for (const RayEcho& echo : surface) add(echo);
  for (const RayEcho& echo : others) add(echo);
  const Eigen::Vector3f axis_world = sent.rotation * footprint_.axes().col(static_cast<Eigen::Index>(beam));
  double water_m = axis_world.z() > 0 ? sent.depth_m / axis_world.z() : fan_.range_max_m;
  for (const RayEcho& echo : surface) water_m = std::min(water_m, double{echo.range_m});
  const auto absorbed = [&](double range_m) {  // there and back, as a natural logarithm
    const double depth_m = std::max(0.0, sent.depth_m - range_m * axis_world.z());
    return -0.2 * std::numbers::ln10 * absorption_.mean_db_m(sent.depth_m, sent.absorbed_db, depth_m) * range_m;
  };
  // Echo and noise are both complex Gaussian, so that each range cell's power is exponential about their sum.
  std::uint64_t key = mixed(stream_.key() ^ (static_cast<std::uint64_t>(stream_.stream()) << 32));
  key = mixed(mixed(key ^ sent.tick) ^ (static_cast<std::uint64_t>(beam) << 40));
  ColumnSamples samples{};
  samples.noise = footprint_.widening(beam);
  samples.system_ratio = static_cast<float>(detector_.system_ratio());
  samples.step_m = static_cast<float>(sample_m);
  samples.water_m = static_cast<float>(water_m);
  samples.key = static_cast<std::uint32_t>(key);
  samples.second_key = static_cast<std::uint32_t>(key >> 32);
  samples.cells = static_cast<std::uint32_t>(std::lround(sample_m / sent.cell_m));
  samples.level_db = static_cast<float>(-lossless_snr_db_);
  const BeamKernels& kernels = beam_kernels();
  float* level_db = ping.water_column_db.data() + beam * sent.samples;
  for (std::size_t k = 0; k < sent.samples; k += kLanes) {
    const double from_m = static_cast<double>(k) * sample_m, to_m = from_m + kLanes * sample_m;
    samples.echoes = power.data() + k;
    samples.index = static_cast<std::uint32_t>(k);
    samples.first_m = static_cast<float>(from_m + 0.5 * sample_m);
    samples.volume = 0;
    if (volume_strength_ > 0 && from_m < water_m) {
      samples.volume = static_cast<float>(volume_at_1m(sent, beam));
      samples.rate = static_cast<float>((absorbed(to_m) - absorbed(from_m)) / kLanes);
      samples.lost = static_cast<float>(std::exp(absorbed(0.5 * (from_m + to_m))));
    }
    std::array<float, kLanes> block;
    kernels.column(samples, block.data());
    std::copy_n(block.begin(), std::min(kLanes, sent.samples - k), level_db + k);
  }
}

}  // namespace uwsim
