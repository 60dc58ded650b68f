#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/optics.h"
#include "uwsim/camera/picture_request.h"
#include "uwsim/camera/wave_grid.h"

namespace uwsim {

/// The sun and the scattering that spreads its focused light, in the band in which water is clearest to the eye.
FocusedSun focused_sun(const Optics& optics);

/// The constants of one picture in the form that the kernels require, and the memory that they point to.
class PreparedView {
 public:
  PreparedView(const CameraScene& scene, const Camera& camera, const Optics& optics, const PictureRequest& request);
  PreparedView(const PreparedView&) = delete;
  PreparedView& operator=(const PreparedView&) = delete;

  camera::View view{};
  Eigen::Vector3d anchor_world_m;  ///< the origin of View's positions: the camera

 private:
  void set_patterns();
  void set_rays(const Camera& camera, const PictureRequest& request);
  void set_shutter(const Camera& camera, const PictureRequest& request);
  void set_wobble(const Camera& camera, const Optics& optics, const PictureRequest& request);
  void set_terrain(const World& world);
  void set_light(const Optics& optics, const PictureRequest& request);
  void set_detail(const CameraScene& scene, const Optics& optics);
  void set_swell(const Water& water, const FocusedSun& sun);
  void set_lamps(const PictureRequest& request);
  /// The first level of the caustics that the picture needs.
  int first_caustic_level(const PictureRequest& request) const;

  std::optional<WaveGrid> waves_;  // where light meets the surface
  std::shared_ptr<const Ripples::Snapshot> ripples_;
  std::vector<camera::SpotLight> lamps_;
};

}  // namespace uwsim
