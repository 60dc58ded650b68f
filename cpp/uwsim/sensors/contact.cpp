#include "uwsim/sensors/sensor.h"

namespace uwsim {
namespace {

/// Reads 1 while the vehicle is in contact with anything, else 0.
class Contact final : public Sensor {
 public:
  explicit Contact(const SensorSpec&) {}
  void observe(const SensorInput& input, std::span<double> raw) const override { raw[0] = input.vehicle.touching; }
};

constexpr Field kContactFields[] = {{"touching", 1, "1"}};

}  // namespace

extern const SensorKind kContact;
constinit const SensorKind kContact = {
    "contact",           "1 while the vehicle is in contact with anything, else 0", kContactFields, {}, 1, {},
    make_sensor<Contact>};

}  // namespace uwsim
