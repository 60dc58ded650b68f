#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwsim/world/heightfield.h"
#include "uwsim/world/swarm.h"

namespace uwsim {

struct SchoolSpec {
  std::string name;
  std::size_t count = 0;
  /// For each size, the body in each phase of a stroke of its tail: x ahead, z up, origin in its middle.
  std::vector<std::vector<TriangleMesh>> shapes_m;
  Eigen::Vector3d home_world_m = Eigen::Vector3d::Zero();  ///< middle of the course
  double round_m = 5;                                      ///< radius of the course
  double speed_m_s = 0.5;
  Eigen::Vector3d spread_m = Eigen::Vector3d::Ones();  ///< half-axes of the ellipsoid they fill: along, across, up
  double stroke_hz = 2;
  double clear_m = 0.5;  ///< from bed and surface
  std::uint64_t seed = 0;

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// A school of fish, whose places are a function of time, so that nothing of it is saved. Its middle swims a closed
/// course, a circle with a second harmonic; each fish keeps a place in the school, as far behind as its lag, and sways
/// about it. Heights are pressed smoothly between bed and surface. The school does not react to vehicles or obstacles.
class School final : public Swarm {
 public:
  /// Throws InvalidValue. Shares the terrain, which may be null.
  School(SchoolSpec spec, std::shared_ptr<const Heightfield> terrain);

  const SchoolSpec& spec() const { return spec_; }
  const std::string& name() const override { return spec_.name; }
  const std::vector<std::vector<TriangleMesh>>& shapes_m() const override { return spec_.shapes_m; }
  std::size_t size() const override { return spec_.count; }
  /// Consecutive fish are neighbours: the place in the school of each is near that of the next.
  void place(double time_s, std::span<Swimmer> fish) const override;
  Eigen::Vector3d middle_world_m() const override { return spec_.home_world_m; }
  double reach_m() const override;

 private:
  struct Place {
    double across_m = 0, up_m = 0;
    double lag_cos = 1, lag_sin = 0;            // of the course's angle
    double sway_cos[3] = {}, sway_sin[3] = {};  // of the phases of the sway along each axis
    double stroke = 0;                          // phase, of 1
    std::size_t rhythm = 0, size = 0;
  };
  struct Course {
    Eigen::Vector3d position;
    Eigen::Vector2d by_angle;  // its derivative
  };
  Course course(double cosine, double sine) const;
  double angle(double time_s) const;

  SchoolSpec spec_;
  std::shared_ptr<const Heightfield> terrain_;
  std::vector<Place> places_;
  double rate_rad_s_, start_rad_;
  Eigen::Vector3d bend_cos_, bend_sin_;  // phases of the second harmonic, x and y, and of the height
  double sway_m_;
};

}  // namespace uwsim
