#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "meshes.h"
#include "uwsim/sonar/imaging/imaging_kinds.h"

/// A flat bed, and imaging sonars without speckle, noise or gain.
namespace uwsim::testing {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kSilence_db = -300;

inline World flat_bed(double z_m, double half_m = 300) {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, static_cast<float>(z_m)), 2, 2, 2 * half_m, {-half_m, -half_m}));
  return world;
}

inline Pose at(const Eigen::Vector3d& position_m, double pitch_rad = 0) {
  return {position_m, Eigen::Quaterniond(Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()))};
}

/// A kind of imaging sonar and its parameters, which tests can change before creating the sonar.
struct ImagingModel {
  std::string kind;
  ParameterValues parameters;

  double& operator[](const std::string& name) {
    parameters[name].resize(1);
    return parameters[name].front();
  }
  double operator[](const std::string& name) const { return parameters.at(name).front(); }
  std::unique_ptr<ImagingSonar> make() const { return imaging_sonar(kind, parameters); }
  ImagingAcoustics acoustics() const { return make()->acoustics(); }
};

/// The scene and the position of a ping; the defaults suit a single ping.
struct Pings {
  std::vector<Pose> poses;
  std::vector<double> angles_rad = {};
  int threads = 1;
  std::uint64_t first_ping = 0;
  std::uint64_t seed = 7;
  bool with_labels = false;
};

/// The values of one of the sonar's arrays.
inline std::vector<float> values_of(const ImagingModel& model, const World& world, const Pings& pings,
                                    std::string_view array) {
  const RayScene scene(world);
  const RandomStream random(pings.seed, "imaging");
  const std::vector<ImagingArray> arrays = model.make()->ping(
      {scene, world.water, pings.poses, pings.angles_rad, random, pings.first_ping, pings.threads, pings.with_labels});
  return std::find_if(arrays.begin(), arrays.end(), [&](const ImagingArray& a) { return a.name == array; })->values;
}

inline ImagingModel quiet(const std::string& kind, double range_max_m, int bins) {
  ImagingModel model{kind, {}};
  model["frequency_hz"] = 450e3;
  model["source_level_db"] = 200;
  model["noise_level_db"] = kSilence_db;
  model["bottom_strength_db"] = -30;
  model["solid_strength_db"] = -20;
  model["range_max_m"] = range_max_m;
  model["range_bins"] = bins;
  model["time_varied_gain"] = 0;
  model["gain_db_decade"] = 50;
  model["looks"] = 0;
  return model;
}

inline ImagingModel quiet_forward_looking() {
  ImagingModel model = quiet("forward_looking", 40, 400);
  model["beams"] = 61;
  model["field_of_view_rad"] = 60 * kDegree;
  model["beam_width_rad"] = 1.5 * kDegree;
  model["vertical_width_rad"] = 170 * kDegree;
  model["taper"] = 0.25;
  model["columns_per_beam"] = 3;
  model["rays_per_column"] = 4000;
  return model;
}

inline ImagingModel quiet_side_scan() {
  ImagingModel model = quiet("side_scan", 50, 500);
  model["along_width_rad"] = 0.5 * kDegree;
  model["vertical_width_rad"] = 60 * kDegree;
  model["depression_rad"] = 30 * kDegree;
  model["planes"] = 3;
  model["detection_db"] = 12;
  return model;
}

inline ImagingModel quiet_single_beam() {
  ImagingModel model = quiet("single_beam", 20, 2000);
  model["beam_width_rad"] = 1.8 * kDegree;
  model["rays_across"] = 21;
  model["detection_db"] = 15;
  return model;
}

}  // namespace uwsim::testing
