#include "uwsim/sonar/forward_looking.h"

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/sonar/beam_pattern.h"
#include "uwsim/sonar/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kFloor = 1e-4;  // -40 dB, what leaks into a transducer from all around; assumed
constexpr double kVerticalTaper = 0.46;
constexpr double kVerticalSpan = 1.25;  // of the width, to either side; past it a Hamming pattern is below -30 dB
constexpr double kAcrossSpan = 6;       // of the beam's width, to either side: main lobe and some side lobes
constexpr double kMostCells = 4e9;      // random draws are numbered by 32 bits

/// Rays of a column, about the level: solid angle and vertical pattern.
std::vector<ArcRay> column_rays(const ForwardLookingModel& model, double spacing_rad) {
  const double span = std::min(kVerticalSpan * model.vertical_width_rad, std::numbers::pi / 2);
  const double step = 2 * span / model.rays_per_column;
  std::vector<double> angles;
  for (int k = 0; k < model.rays_per_column; ++k) angles.push_back(-span + (k + 0.5) * step);
  std::vector<ArcRay> rays = arc_rays(angles);
  const BeamPattern vertical(model.vertical_width_rad, kVerticalTaper, kFloor);
  for (ArcRay& ray : rays) {
    ray.gain_sr = vertical.power(ray.angle_rad) * std::cos(ray.angle_rad) * step * spacing_rad;
  }
  return rays;
}

/// An upright plane through the head's z axis.
RayArc column_at(const Eigen::Matrix3d& rotation, double bearing_rad, double spacing_rad) {
  const double c = std::cos(bearing_rad), s = std::sin(bearing_rad);
  return {rotation * Eigen::Vector3d(c, s, 0), rotation.col(2), rotation * Eigen::Vector3d(-s, c, 0), 0,
          spacing_rad / 2};
}

}  // namespace

void ForwardLookingModel::check() const {
  acoustics.check();
  require(beams >= 1 && beams <= 4096, "sonar.beams", beams, "must be in [1, 4096]");
  require(field_of_view_rad > 0 && field_of_view_rad <= 2 * std::numbers::pi, "sonar.field_of_view_rad",
          field_of_view_rad, "must be in (0, 2 pi] rad");
  require(beam_width_rad >= 1e-4 && beam_width_rad <= std::numbers::pi, "sonar.beam_width_rad", beam_width_rad,
          "must be in [1e-4, pi] rad");
  require(vertical_width_rad >= 1e-4 && vertical_width_rad <= std::numbers::pi, "sonar.vertical_width_rad",
          vertical_width_rad, "must be in [1e-4, pi] rad");
  require(columns_per_beam >= 1 && columns_per_beam <= 64, "sonar.columns_per_beam", columns_per_beam,
          "must be in [1, 64]");
  require(rays_per_column >= 2 && rays_per_column <= 16384, "sonar.rays_per_column", rays_per_column,
          "must be in [2, 16384]");
  require(1.0 * beams * acoustics.range_bins * std::max(acoustics.looks, 1) < kMostCells, "sonar.range_bins",
          acoustics.range_bins, "times beams and looks must be below 4e9");
}

std::vector<float> forward_look(const ForwardLookingModel& model, const RayScene& scene, const Water& water,
                                const Pose& world_from_sonar, const RandomStream& random, std::uint64_t tick,
                                int threads) {
  model.check();
  const ImagingAcoustics& acoustics = model.acoustics;
  const double absorption = acoustics.absorption_db_m(water, world_from_sonar.position_m.z());
  const double spacing = model.spacing_rad() / model.columns_per_beam;
  const auto bins = static_cast<std::size_t>(acoustics.range_bins), beams = static_cast<std::size_t>(model.beams);
  const auto per_beam = static_cast<std::size_t>(model.columns_per_beam);
  // Columns reach past the outermost beams as far as a beam hears.
  const double reach_rad = std::min(kAcrossSpan * model.beam_width_rad, std::numbers::pi / 2);
  const auto reach = static_cast<std::size_t>(std::ceil(reach_rad / spacing));
  const std::size_t columns = (beams - 1) * per_beam + 1 + 2 * reach;

  const SurfaceEchoes echoes(scene, world_from_sonar.position_m, acoustics, absorption);
  const std::vector<ArcRay> rays = column_rays(model, spacing);
  const Eigen::Matrix3d rotation = world_from_sonar.rotation();
  std::vector<double> profiles(columns * bins, 0.0);
  parallel_ranges(
      columns, threads,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
          const double bearing = model.bearing_rad(0) + (static_cast<double>(k) - static_cast<double>(reach)) * spacing;
          echoes.add(column_at(rotation, bearing, spacing), rays, {profiles.data() + k * bins, bins});
        }
      },
      1);

  const BeamPattern across(model.beam_width_rad, model.taper, kFloor);
  std::vector<double> weights;
  for (std::size_t k = 0; k <= 2 * reach; ++k) {
    weights.push_back(across.power((static_cast<double>(k) - static_cast<double>(reach)) * spacing));
  }
  const ImagingReceiver receiver(acoustics, absorption, random);
  std::vector<float> levels(bins * beams);
  parallel_ranges(
      beams, threads,
      [&](std::size_t first, std::size_t last) {
        std::vector<double> heard(bins);
        for (std::size_t beam = first; beam < last; ++beam) {
          std::fill(heard.begin(), heard.end(), 0.0);
          for (std::size_t k = 0; k < weights.size(); ++k) {
            const double* profile = profiles.data() + (beam * per_beam + k) * bins;
            for (std::size_t bin = 0; bin < bins; ++bin) heard[bin] += weights[k] * profile[bin];
          }
          for (std::size_t bin = 0; bin < bins; ++bin) {
            const std::size_t cell = bin * beams + beam;
            levels[cell] = receiver.shown_db(receiver.received(heard[bin], tick, static_cast<std::uint32_t>(cell)),
                                             acoustics.bin_centre_m(static_cast<int>(bin)));
          }
        }
      },
      1);
  return levels;
}

}  // namespace uwsim
