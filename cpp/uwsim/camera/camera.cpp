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
  const double wobble_rad = sensor.wobble_rad.value_or(0);
  require(wobble_rad >= 0 && wobble_rad <= 0.1, "camera.wobble_rad", wobble_rad, "must be in [0, 0.1] rad");
  require(sensor.shutter_s >= 0 && sensor.shutter_s <= 10, "camera.shutter_s", sensor.shutter_s,
          "must be in [0, 10] s");
  require(sensor.readout_s >= 0 && sensor.readout_s <= 10, "camera.readout_s", sensor.readout_s,
          "must be in [0, 10] s");
  undistorted_ = ray_table(lens_, false);
  distorted_ = ray_table(lens_, true);
  require(2 * distorted_.folded <= distorted_.x.size(), "camera.distortion", distorted_.folded,
          "is the number of pixels that no ray meets, more than half: the distortion folds the image over; make it "
          "smaller");
  if (lens_.port) refracted_ = ray_table(lens_, true, true);
}

}  // namespace uwsim
