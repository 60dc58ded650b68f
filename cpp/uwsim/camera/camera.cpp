#include "uwsim/camera/camera.h"

#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {

Camera::Camera(std::string name, const Lens& lens, const ImageSensor& sensor)
    : name_(std::move(name)), lens_(lens), sensor_(sensor) {
  lens_.check();
  require(sensor.exposure >= 1e-3 && sensor.exposure <= 1e3, "camera.exposure", sensor.exposure,
          "must be in [0.001, 1000]");
  require(sensor.full_well >= 1 && sensor.full_well <= 1e9, "camera.full_well", sensor.full_well,
          "must be in [1, 1e9] electrons");
  require(sensor.read_noise >= 0 && sensor.read_noise <= 1e6, "camera.read_noise", sensor.read_noise,
          "must be in [0, 1e6] electrons");
  require(sensor.vignetting >= 0 && sensor.vignetting <= 1, "camera.vignetting", sensor.vignetting,
          "must be in [0, 1]");
  require(sensor.wobble_rad >= 0 && sensor.wobble_rad <= 0.1, "camera.wobble_rad", sensor.wobble_rad,
          "must be in [0, 0.1] rad");
  plain_ = ray_table(lens_, false);
  distorted_ = ray_table(lens_, true);
}

void Lamp::check() const {
  require(world_from_lamp.position_m.allFinite(), "lamp.position_m", world_from_lamp.position_m.transpose(),
          "must be finite");
  require(flux_lm >= 0 && flux_lm <= 1e8, "lamp.flux_lm", flux_lm, "must be in [0, 1e8] lm");
  require(half_angle_rad >= 0.01 && half_angle_rad <= 1.5, "lamp.half_angle_rad", half_angle_rad,
          "must be in [0.01, 1.5] rad");
  require(soft_share >= 0.01 && soft_share <= 1, "lamp.soft_share", soft_share, "must be in [0.01, 1]");
  require((colour >= 0).all() && (colour <= 10).all(), "lamp.colour", colour.transpose(), "must be in [0, 10]");
}

}  // namespace uwsim
