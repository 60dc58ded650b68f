#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "uwsim/core/random.h"
#include "uwsim/world/swarm.h"

namespace uwsim {

struct PlumeSpec {
  std::string name;
  std::size_t count = 0;  ///< of clusters of bubbles
  /// For each of some equal parts of the way up, the shapes of a cluster there; each cluster keeps one.
  std::vector<std::vector<TriangleMesh>> shapes_m;
  Eigen::Vector3d source_world_m = Eigen::Vector3d::Zero();
  double top_z_m = 0;      ///< where bubbles end
  double rise_m_s = 0.23;  ///< of bubbles of 3 to 10 mm (Clift, Grace and Weber 1978, "Bubbles, Drops, and Particles")
  double widens = 0.1;     ///< growth of the plume's radius with height (Milgram 1983, J. Fluid Mech. 133:345)
  Eigen::Vector3d drift_m_s = Eigen::Vector3d::Zero();  ///< of the water: a steady current
  std::uint64_t seed = 0;

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// Bubbles that rise from a leak or a seep, in clusters: each rises steadily, drifts with the current and moves away
/// from the axis as the plume widens; at the top, it starts again elsewhere in the plume. Places are Gaussian about the
/// axis, and 90 % of the clusters are within the plume's radius. The water that rises with a plume is not modelled.
class Plume final : public Swarm {
 public:
  /// Throws InvalidValue.
  explicit Plume(PlumeSpec spec);

  const std::string& name() const override { return spec_.name; }
  const std::vector<std::vector<TriangleMesh>>& shapes_m() const override { return spec_.shapes_m; }
  std::size_t size() const override { return spec_.count; }
  void place(double time_s, std::span<Swimmer> bodies) const override;
  Eigen::Vector3d middle_world_m() const override;
  double reach_m() const override;

 private:
  double height_m() const { return spec_.top_z_m - spec_.source_world_m.z(); }

  PlumeSpec spec_;
  RandomStream random_;
};

}  // namespace uwsim
