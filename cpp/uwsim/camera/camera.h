#pragma once

#include <optional>
#include <string>

#include "uwsim/camera/lens.h"

namespace uwsim {

/// The conversion of light to bytes.
struct ImageSensor {
  double exposure = 1;      ///< the fixed exposure, or, with automatic exposure, a factor applied to it
  double full_well = 8000;  ///< electrons at full scale and base gain; assumed, typical of a small sensor
  double read_noise = 6;    ///< electrons; assumed
  double vignetting = 0.5;  ///< fraction of the cos^4 law; assumed, for lenses that correct part of it
  /// Largest deflection of a ray by turbulence; if unset, derived from the water's turbulence
  std::optional<double> wobble_rad;
  double shutter_s = 0;  ///< how long each row collects light, which causes motion blur
  double readout_s = 0;  ///< from the first row's exposure to the last's (rolling shutter); 0: all rows at once
};

/// A camera: lens and sensor. Its frame is x ahead, y left, z up, like that of a body; the optical axis is its x axis.
class Camera {
 public:
  /// `name` keys its noise, such as "rov/front". Throws InvalidValue.
  Camera(std::string name, const Lens& lens, const ImageSensor& sensor);

  const std::string& name() const { return name_; }
  const Lens& lens() const { return lens_; }
  const ImageSensor& sensor() const { return sensor_; }
  /// `in_water`: whether a flat port, if the camera has one, refracts the rays. The port counts as part of the lens, so
  /// it has no effect without distortion.
  const RayTable& rays(bool distort, bool in_water) const {
    return !distort ? undistorted_ : in_water && lens_.port ? refracted_ : distorted_;
  }

 private:
  std::string name_;
  Lens lens_;
  ImageSensor sensor_;
  RayTable distorted_, undistorted_, refracted_;
};

}  // namespace uwsim
