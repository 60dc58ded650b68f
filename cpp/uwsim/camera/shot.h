#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/renderer.h"
#include "uwsim/camera/wave_window.h"

namespace uwsim {

/// A picture's constants as the kernels take them, and what they point to.
class PreparedShot {
 public:
  PreparedShot(const CameraScene& scene, const Camera& camera, const Optics& optics, const Exposure& exposure);
  PreparedShot(const PreparedShot&) = delete;
  PreparedShot& operator=(const PreparedShot&) = delete;

  camera::Shot shot{};
  Eigen::Vector3d anchor_world_m;
  bool in_water_world;  ///< any effect of water is on

 private:
  void aim(const Camera& camera, const Exposure& exposure);
  void lay_terrain(const World& world);
  void fill_water(const Optics& optics, const Effects& effects);
  void light_lamps(const Exposure& exposure);

  std::optional<WaveField> waves_;  // where light meets the surface
  std::shared_ptr<const Ripples::Moment> ripples_;
  std::vector<camera::LampLight> lamps_;
};

}  // namespace uwsim
