#pragma once

#include <cmath>
#include <numbers>

#include "meshes.h"
#include "uwsim/sonar/forward_looking.h"
#include "uwsim/sonar/side_scan.h"
#include "uwsim/sonar/single_beam.h"

/// A flat bed, and sonars without speckle, noise or gain to hear it with.
namespace uwsim::testing {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kSilence_db = -300;

inline World flat_bed(double z_m) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, static_cast<float>(z_m)), 2, 2, 600.0, {-300, -300}));
  return world;
}

inline Pose at(const Eigen::Vector3d& position_m, double pitch_rad = 0) {
  return {position_m, Eigen::Quaterniond(Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()))};
}

inline ImagingAcoustics quiet(double range_max_m, int bins) {
  ImagingAcoustics acoustics;
  acoustics.frequency_hz = 450e3;
  acoustics.source_level_db = 200;
  acoustics.noise_level_db = kSilence_db;
  acoustics.bottom_strength_db = -30;
  acoustics.solid_strength_db = -20;
  acoustics.range_max_m = range_max_m;
  acoustics.range_bins = bins;
  acoustics.time_varied_gain = false;
  acoustics.gain_db_decade = 50;
  acoustics.looks = 0;
  return acoustics;
}

inline ForwardLookingModel quiet_forward_looking() {
  ForwardLookingModel model;
  model.acoustics = quiet(40, 400);
  model.beams = 61;
  model.field_of_view_rad = 60 * kDegree;
  model.beam_width_rad = 1.5 * kDegree;
  model.vertical_width_rad = 170 * kDegree;
  model.taper = 0.25;
  model.columns_per_beam = 3;
  model.rays_per_column = 4000;
  return model;
}

inline SideScanModel quiet_side_scan() {
  SideScanModel model;
  model.acoustics = quiet(50, 500);
  model.along_width_rad = 0.5 * kDegree;
  model.vertical_width_rad = 60 * kDegree;
  model.depression_rad = 30 * kDegree;
  model.planes = 3;
  model.detection_db = 12;
  return model;
}

inline SingleBeamModel quiet_single_beam() {
  SingleBeamModel model;
  model.acoustics = quiet(20, 2000);
  model.beam_width_rad = 1.8 * kDegree;
  model.rays_across = 21;
  model.detection_db = 15;
  return model;
}

/// level[bin * beams + beam] of one beam.
inline std::vector<double> beam_of(const std::vector<float>& levels, int beams, int beam) {
  std::vector<double> column;
  for (std::size_t k = static_cast<std::size_t>(beam); k < levels.size(); k += static_cast<std::size_t>(beams)) {
    column.push_back(levels[k]);
  }
  return column;
}

}  // namespace uwsim::testing
