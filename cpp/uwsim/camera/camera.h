#pragma once

#include <string>

#include "uwsim/camera/lens.h"
#include "uwsim/camera/water_optics.h"
#include "uwsim/core/pose.h"

namespace uwsim {

/// How light becomes bytes.
struct ImageSensor {
  double exposure = 1;       ///< of the fixed exposure, and a correction of the automatic one
  double full_well = 8000;   ///< electrons at full scale and base gain: assumed, a small sensor's
  double read_noise = 6;     ///< electrons: assumed
  double vignetting = 0.5;   ///< share of the cos^4 law: assumed, for lenses that correct some of it
  double wobble_rad = 8e-4;  ///< greatest bend of a ray by turbulence: assumed
};

/// A camera: lens and sensor. Its frame is x ahead, y left, z up, as a body's; the optical frame looks along it.
class Camera {
 public:
  /// `name` keys its noise, such as "rov/front". Throws InvalidValue.
  Camera(std::string name, const Lens& lens, const ImageSensor& sensor);

  const std::string& name() const { return name_; }
  const Lens& lens() const { return lens_; }
  const ImageSensor& sensor() const { return sensor_; }
  const RayTable& rays(bool distort) const { return distort ? distorted_ : plain_; }

 private:
  std::string name_;
  Lens lens_;
  ImageSensor sensor_;
  RayTable distorted_, plain_;
};

/// A spot lamp: even within the inner angle, dark from the outer on, smooth between.
struct Lamp {
  Pose world_from_lamp;  ///< shines along x
  double flux_lm = 10'000;
  double half_angle_rad = 0.6;   ///< where it is dark
  double soft_share = 0.4;       ///< of the half angle, over which it falls off
  Bands colour = Bands::Ones();  ///< relative to daylight's white

  void check() const;
};

}  // namespace uwsim
