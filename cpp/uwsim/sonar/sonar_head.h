#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/pose.h"
#include "uwsim/core/random.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/sonar/acoustic_multibeam.h"
#include "uwsim/sonar/multibeam.h"

namespace uwsim {

/// Everything needed to create a vehicle's multibeam sonar.
struct SonarSpec {
  std::string name;
  MultibeamModel model = em2040(2);
  Pose body_from_mount;
  double elevation_rad = 0;               ///< initial elevation of the head
  std::optional<AcousticSpec> acoustics;  ///< selects physics mode; if unset, geometry mode
  std::vector<double> strengths_db = {};  ///< backscatter by label in geometry mode, see Multibeam
  bool on = true;                         ///< when off, the head tilts but receives nothing
};

/// The head of a vehicle's multibeam sonar. It tilts about its y axis and pings in geometry mode (one exact ray for
/// each beam) or, if it has acoustics, in physics mode.
class SonarHead {
 public:
  /// `stream`: source of random draws in physics mode. Copies the required parts of `water`. Throws InvalidValue.
  SonarHead(const SonarSpec& spec, const Water& water, const RandomStream& stream);

  const std::string& name() const { return name_; }
  const Multibeam& multibeam() const { return multibeam_; }
  bool in_physics_mode() const { return acoustics_.has_value(); }

  /// Sets the target elevation, positive up; the head turns towards it at the model's tilt rate. Throws InvalidValue
  /// beyond +-pi/2.
  void aim(double elevation_rad);
  /// Turns the head towards its target elevation.
  void advance(double duration_s);
  /// The present elevation and the target elevation.
  double elevation_rad() const { return elevation_rad_; }
  double aimed_rad() const { return aimed_rad_; }
  /// The present mounting pose, including the elevation.
  Pose body_from_sonar() const;
  /// Saves or restores both elevations. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

  /// Pings in geometry mode; also available on heads in physics mode.
  void ping(const RayScene& scene, const Water& water, const Pose& world_from_body, const PingRows& rows) const;
  MultibeamPing ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const;
  /// Pings in physics mode from a moving body. Random draws are keyed by `tick`. Throws InvalidValue in geometry mode.
  AcousticPing acoustic_ping(const RayScene& scene, const BodyState& body, std::uint64_t tick, int threads = 1,
                             const PingRequest& request = {}) const;

 private:
  std::string name_;
  Multibeam multibeam_;
  std::optional<AcousticMultibeam> acoustics_;
  Pose body_from_mount_;
  double elevation_rad_ = 0, aimed_rad_ = 0;
};

}  // namespace uwsim
