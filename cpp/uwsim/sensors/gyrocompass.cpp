#include <cmath>
#include <numbers>

#include "uwsim/sensors/mounted_sensor.h"

namespace uwsim {
namespace {

/// True heading of the sensor's x axis, clockwise from north, in [0, 2 pi), by the Earth's rotation, of which only the
/// level part Omega cos(latitude) points north. A torque or a gyroscope's bias b therefore turns it by b / (Omega
/// cos(latitude)): its errors are those of `heading` times the secant of the latitude. Makers and ISO 8728:2014, "Ships
/// and marine technology: marine gyro-compasses", state them so. The error by its own speed is taken to be corrected,
/// as IMO A.424(XI) asks of ships.
class Gyrocompass final : public MountedSensor {
 public:
  explicit Gyrocompass(const SensorSpec& spec)
      : MountedSensor(spec), secant_(1 / std::cos(spec.number("latitude_deg") * std::numbers::pi / 180)) {}

  void observe(const SensorInput& input, std::span<double> raw) const override {
    const Eigen::Vector3d ahead = world_from_sensor(input).direction(Eigen::Vector3d::UnitX());
    raw[0] = 0;
    raw[1] = std::atan2(ahead.x(), ahead.y());
  }

  bool report(std::span<const double> raw, std::span<double> reading) const override {
    reading[0] = turned_once_rad(raw[1] + secant_ * raw[0]);
    return true;
  }

 private:
  double secant_;
};

constexpr Field kGyrocompassFields[] = {{"heading_rad", 1, "rad"}};
constexpr Channel kGyrocompassChannels[] = {{"heading", 1, "rad"}};
constexpr Parameter kGyrocompassParameters[] = {
    {"latitude_deg", 1, 0, -89, 89, "deg",
     "by whose secant the errors grow; of the scenario's `earth`, if it has one"}};

}  // namespace

extern const SensorKind kGyrocompass;
constinit const SensorKind kGyrocompass = {"gyrocompass",
                                           "true heading by the Earth's rotation, clockwise from north",
                                           kGyrocompassFields,
                                           kGyrocompassChannels,
                                           1,
                                           kGyrocompassParameters,
                                           make_sensor<Gyrocompass>};

}  // namespace uwsim
