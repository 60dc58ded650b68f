#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/image_buffer.h"
#include "uwsim/core/parallel.h"
#include "uwsim/sonar/beam_angles.h"
#include "uwsim/sonar/imaging/beam_pattern.h"
#include "uwsim/sonar/imaging/fan_speckle.h"
#include "uwsim/sonar/imaging/imaging_kernels.h"
#include "uwsim/sonar/imaging/imaging_sonar.h"
#include "uwsim/sonar/imaging/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kLeakage = 1e-4;  // -40 dB: leakage into a transducer from all directions; assumed
constexpr double kVerticalTaper = 0.46;
// Half the span of the columns' rays, as a multiple of the width; beyond it, a Hamming pattern is below -30 dB.
constexpr double kVerticalSpan = 1.25;
constexpr double kAcrossSpan = 6;  // multiple of the beam's width, to either side: main lobe and some side lobes
constexpr std::size_t kBeamsTogether = 4;     // as the kernel sums up
constexpr std::size_t kBeamsAside = 16;       // a multiple of these, written together
constexpr std::size_t kColumnsTogether = 32;  // a multiple of SurfaceEchoes::kArcsTogether
constexpr double kMaxDraws = 4e9;             // random draws of a ping are numbered by 32 bits

/// A forward-looking imaging sonar with one broad transmission and many narrow receiving beams side by side. Pings
/// once, from one pose, and returns level_db (bins, beams), dB re 1 uPa, with the time-varied gain if it is on, and on
/// request labels (bins, beams). Bearings are about the sonar's +z axis, positive to port; its x axis is the middle of
/// the picture.
///
/// Columns of rays sample the scene over the vertical aperture, at elevations that alternate between columns; each beam
/// is the sum of the columns' echoes, weighted by the receiving array's pattern. Not modelled: echoes of the surface
/// and multiple reflections, motion within a ping, and the curvature of a line array's beams away from the level plane.
class ForwardLooking final : public ImagingSonar {
 public:
  ForwardLooking(const ImagingAcoustics& acoustics, const ParameterValues& parameters)
      : ImagingSonar(acoustics),
        beams_(static_cast<std::size_t>(whole_number(parameters, "beams"))),
        columns_per_beam_(static_cast<std::size_t>(whole_number(parameters, "columns_per_beam"))),
        rays_per_column_(whole_number(parameters, "rays_per_column")),
        bins_(static_cast<std::size_t>(acoustics.range_bins)),
        vertical_width_rad_(number(parameters, "vertical_width_rad")),
        across_(number(parameters, "beam_width_rad"), number(parameters, "taper"), kLeakage) {
    require(1.0 * static_cast<double>(beams_ * bins_) * std::max(acoustics.looks, 1) < kMaxDraws, "sonar.range_bins",
            acoustics.range_bins, "times beams and looks must be below 4e9");
    const double field_of_view_rad = number(parameters, "field_of_view_rad");
    const double beam_width_rad = number(parameters, "beam_width_rad");
    // A single beam has no neighbours, so its columns are spread over its width.
    const BeamAngles bearings = beams_ > 1 ? even_beam_angles(field_of_view_rad, static_cast<int>(beams_))
                                           : BeamAngles{-field_of_view_rad / 2, beam_width_rad};
    first_bearing_rad_ = bearings.first_rad;
    spacing_rad_ = bearings.spacing_rad / static_cast<int>(columns_per_beam_);
    // Columns extend beyond the outermost beams as far as a beam's pattern does.
    const double reach_rad = std::min(kAcrossSpan * beam_width_rad, std::numbers::pi / 2);
    reach_ = static_cast<std::size_t>(std::ceil(reach_rad / spacing_rad_));
  }

  std::vector<ImagingArray> ping(const ImagingRequest& request) const override {
    require(request.world_from_sonar.size() == 1, "poses.size", request.world_from_sonar.size(), "must be 1");
    const Pose& pose = request.world_from_sonar.front();
    const double absorption = acoustics().absorption_db_m(request.water, pose.position_m.z());
    std::vector<EchoesByLabel> by_label(request.with_labels ? columns() : 0, EchoesByLabel(bins_));
    const ImageBuffer<float> profiles = column_profiles(request, pose, absorption, by_label);
    const ImagingReceiver receiver(acoustics(), absorption, request.random);
    const FanSpeckle speckle({across_, vertical_width_rad_}, acoustics(), request.random, pose, bearing_rad(0),
                             bearing_rad(beams_ - 1), request.threads);
    const std::vector<double> weights = column_weights();
    std::vector<float> levels(bins_ * beams_);
    parallel_batches(
        (beams_ + kBeamsAside - 1) / kBeamsAside, 1, request.threads,
        [&](std::size_t first, std::size_t last, std::size_t) {
          std::vector<double> echoes(kBeamsTogether * blocks() * kBlockBins);
          std::vector<float> aside(kBeamsAside * bins_);
          std::vector<FanSpeckle::Amplitude> row;
          for (std::size_t beam = first * kBeamsAside; beam < std::min(last * kBeamsAside, beams_); ++beam) {
            const std::size_t turn = beam % kBeamsTogether, lane = beam % kBeamsAside;
            if (turn == 0) sum_columns(profiles, weights, beam, std::min(kBeamsTogether, beams_ - beam), echoes);
            const std::span<const FanSpeckle::Amplitude> scattered = speckle.of_beam(bearing_rad(beam), row);
            receiver.receive({request.first_ping, static_cast<std::uint32_t>(beam), static_cast<std::uint32_t>(beams_)},
                             scattered, std::span(echoes).subspan(turn * blocks() * kBlockBins, bins_),
                             std::span(aside).subspan(lane * bins_, bins_));
            if (lane + 1 == kBeamsAside || beam + 1 == beams_) {
              write_aside(aside, lane + 1, {levels.data() + beam - lane, levels.size() - (beam - lane)});
            }
          }
        });
    std::vector<ImagingArray> result;
    result.push_back({"level_db", {bins_, beams_}, std::move(levels)});
    if (request.with_labels) {
      result.push_back(
          {"labels", {bins_, beams_}, labels(by_label, weights, receiver.echo_at_noise(), request.threads)});
    }
    return result;
  }

 private:
  double bearing_rad(std::size_t beam) const {
    return first_bearing_rad_ + static_cast<double>(beam * columns_per_beam_) * spacing_rad_;
  }

  std::size_t columns() const { return (beams_ - 1) * columns_per_beam_ + 1 + 2 * reach_; }

  /// The number of blocks of a column's bins.
  std::size_t blocks() const { return (bins_ + kBlockBins - 1) / kBlockBins; }

  /// Mean echo power by range, one row per column of rays, see ProfileBlocks; also by label, unless the output for
  /// labels is empty.
  ImageBuffer<float> column_profiles(const ImagingRequest& request, const Pose& pose, double absorption,
                                     std::span<EchoesByLabel> by_label) const {
    const std::size_t columns = this->columns();
    const SurfaceEchoes echoes(request.scene, pose.position_m, acoustics(), absorption);
    const ArcRaySets rays = column_rays();
    const Eigen::Matrix3d rotation = pose.rotation();
    ImageBuffer<float> profiles(columns * blocks() * kBlockBins);
    parallel_batches(columns, kColumnsTogether, request.threads, [&](std::size_t first, std::size_t last, std::size_t) {
      std::vector<double> rows(SurfaceEchoes::kArcsTogether * bins_);
      for (; first < last; first += SurfaceEchoes::kArcsTogether) {
        std::vector<RayArc> arcs;
        for (std::size_t k = first; k < std::min(first + SurfaceEchoes::kArcsTogether, last); ++k) {
          arcs.push_back(column_at(
              rotation, first_bearing_rad_ + (static_cast<double>(k) - static_cast<double>(reach_)) * spacing_rad_));
        }
        std::ranges::fill(rows, 0.0);
        echoes.add(arcs, rays, std::span(rows).first(arcs.size() * bins_),
                   by_label.empty() ? by_label : by_label.subspan(first, arcs.size()));
        for (std::size_t k = 0; k < arcs.size(); ++k) {
          imaging_kernels().store_row(rows.data() + k * bins_, bins_, columns,
                                      profiles.data() + (first + k) * kBlockBins);
        }
      }
    });
    return profiles;
  }

  /// Sets of rays in order of elevation, with solid angle and vertical pattern; successive columns take turns in them.
  /// Each set covers the whole span, and their elevations alternate, so that a beam, which receives several columns, is
  /// sampled at four times as many elevations as one column. Rays are denser where the pattern is high: the step
  /// between them is proportional to 1 - a + 3 a u^2, with u from -1 to 1 over the span.
  ArcRaySets column_rays() const {
    constexpr double kBend = 0.4;                        // a
    constexpr std::array<int, 4> kTurns = {0, 2, 1, 3};  // no two neighbours are alike
    const double span = std::min(kVerticalSpan * vertical_width_rad_, std::numbers::pi / 2);
    const auto elevation = [&](double u) { return span * u * (1 - kBend + kBend * u * u); };
    const BeamPattern vertical(vertical_width_rad_, kVerticalTaper, kLeakage);
    std::vector<std::vector<ArcRay>> sets;
    for (const int turn : kTurns) {
      const double shift = (turn + 0.5) / kTurns.size() - 0.5, step = 2.0 / rays_per_column_;
      std::vector<ArcRay> rays;
      for (int k = 0; k < rays_per_column_; ++k) {
        const double from = k == 0 ? -1 : -1 + (k + shift) * step;
        const double to = k + 1 == rays_per_column_ ? 1 : -1 + (k + 1 + shift) * step;
        const double angle = elevation((from + to) / 2), lower = elevation(from), upper = elevation(to);
        const double gain_sr = vertical.power(angle) * std::cos(angle) * (upper - lower) * spacing_rad_;
        rays.push_back({angle, lower, upper, gain_sr, angle, lower, upper});
      }
      sets.push_back(std::move(rays));
    }
    return ArcRaySets(std::move(sets));
  }

  /// A vertical plane of rays through the head's z axis.
  RayArc column_at(const Eigen::Matrix3d& rotation, double bearing_rad) const {
    const double c = std::cos(bearing_rad), s = std::sin(bearing_rad);
    return {rotation * Eigen::Vector3d(c, s, 0), rotation.col(2), rotation * Eigen::Vector3d(-s, c, 0), 0,
            spacing_rad_ / 2};
  }

  /// The receiving array's pattern at the columns on either side of a beam's axis.
  std::vector<double> column_weights() const {
    std::vector<double> weights;
    for (std::size_t k = 0; k <= 2 * reach_; ++k) {
      weights.push_back(across_.power((static_cast<double>(k) - static_cast<double>(reach_)) * spacing_rad_));
    }
    return weights;
  }

  /// Writes the levels (beams, bins) of some beams side by side to (bins, all beams), in whole lines of the cache.
  void write_aside(const std::vector<float>& aside, std::size_t beams, std::span<float> levels) const {
    for (std::size_t bin = 0; bin < bins_; ++bin) {
      for (std::size_t k = 0; k < beams; ++k) levels[bin * beams_ + k] = aside[k * bins_ + bin];
    }
  }

  /// Sets the echoes (4, whole blocks of bins) of some beams, beginning with `beam`.
  void sum_columns(const ImageBuffer<float>& profiles, const std::vector<double>& weights, std::size_t beam,
                   std::size_t beams, std::vector<double>& echoes) const {
    std::vector<float> padded((kBeamsTogether - 1) * columns_per_beam_, 0.0f);
    padded.insert(padded.end(), weights.begin(), weights.end());
    padded.resize(padded.size() + (kBeamsTogether - 1) * columns_per_beam_, 0.0f);
    imaging_kernels().sum_beams({profiles.data() + beam * columns_per_beam_ * kBlockBins, columns(), blocks()},
                                padded.data(), weights.size(), columns_per_beam_, beams, echoes.data());
  }

  /// For each cell, the surface that produces the strongest echo.
  std::vector<float> labels(std::span<const EchoesByLabel> columns, const std::vector<double>& weights, double least,
                            int threads) const {
    std::vector<float> cells(bins_ * beams_);
    parallel_ranges(
        beams_, threads,
        [&](std::size_t first, std::size_t last) {
          for (std::size_t beam = first; beam < last; ++beam) {
            EchoesByLabel echoes(bins_);
            for (std::size_t k = 0; k < weights.size(); ++k) {
              echoes.add(weights[k], columns[beam * columns_per_beam_ + k]);
            }
            for (std::size_t bin = 0; bin < bins_; ++bin) cells[bin * beams_ + beam] = echoes.strongest(bin, least);
          }
        },
        1);
    return cells;
  }

  std::size_t beams_;
  std::size_t columns_per_beam_;  ///< number of vertical planes of rays per beam spacing
  int rays_per_column_;
  std::size_t bins_;
  double vertical_width_rad_;
  BeamPattern across_;
  double first_bearing_rad_, spacing_rad_;  ///< of the columns: the bearing of the first, and the spacing
  std::size_t reach_;                       ///< number of columns beyond the outermost beams
};

constexpr Parameter kForwardLookingParameters[] = {
    {"beams", 1, kRequired, 1, 4096, "", "side by side", ParameterType::kWholeNumber},
    {"field_of_view_rad", 1, kRequired, kAboveZero, 2 * std::numbers::pi, "rad", "between the outermost beams' axes"},
    {"beam_width_rad", 1, kRequired, 1e-4, std::numbers::pi, "rad", "across a beam, between half-power points"},
    {"vertical_width_rad", 1, kRequired, 1e-4, std::numbers::pi, "rad",
     "of transmitter and receiver together, two-way"},
    {"taper", 1, kRequired, 0, 0.5, "", "the receiving array's shading, see BeamPattern"},
    {"columns_per_beam", 1, kRequired, 1, 64, "", "planes of rays for each beam", ParameterType::kWholeNumber},
    {"rays_per_column", 1, kRequired, 2, 16384, "", "from bottom to top; neighbouring planes take turns in four sets",
     ParameterType::kWholeNumber}};

}  // namespace

extern const ImagingKind kForwardLooking;
constinit const ImagingKind kForwardLooking = {"forward_looking", "a picture by range and bearing ahead",
                                               kForwardLookingParameters, make_imaging_sonar<ForwardLooking>};

}  // namespace uwsim
