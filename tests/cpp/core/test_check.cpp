#include <gtest/gtest.h>

#include <Eigen/Core>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

template <typename Value>
std::string message_of(const Value& value) {
  try {
    require(false, "a.path", value, "must hold");
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "nothing was thrown";
}

template <typename Value>
std::string streamed(const Value& value) {
  std::ostringstream text;
  text << "a.path = " << value << ": must hold";
  return text.str();
}

// Law: a value reads in a message as a stream of the standard library, or Eigen's, prints it.
TEST(Check, AMessagePrintsAValueAsAStreamDoes) {
  EXPECT_NO_THROW(require(true, "a.path", 1, "must hold"));
  EXPECT_EQ(message_of(1e300 * 1e10), "a.path = inf: must hold");
  for (const double value : {0.0, -0.0, 0.1, 1234567.0, 1e-7, -2.5, 1.0 / 3}) {
    EXPECT_EQ(message_of(value), streamed(value));
    EXPECT_EQ(message_of(static_cast<float>(value)), streamed(static_cast<float>(value)));
    EXPECT_EQ(message_of(with_unit(value, "m")), "a.path = " + printed(value) + " m: must hold");
  }
  EXPECT_EQ(message_of(true), streamed(true));
  EXPECT_EQ(message_of(-3), streamed(-3));
  EXPECT_EQ(message_of(~std::size_t{0}), streamed(~std::size_t{0}));
  EXPECT_EQ(message_of("none"), streamed("none"));
  EXPECT_EQ(message_of(std::string("x\ny")), streamed(std::string("x\ny")));
  const Eigen::Vector3d vector(-1, 0.25, std::nan(""));
  EXPECT_EQ(message_of(vector.transpose()), streamed(vector.transpose()));
  const Eigen::Array3i counts(7, -1234567, 12);
  EXPECT_EQ(message_of(counts.transpose()), streamed(counts.transpose()));
  EXPECT_EQ(message_of(with_unit((2 * vector).transpose(), "m/s")),
            "a.path = " + printed((2 * vector).transpose()) + " m/s: must hold");
}

}  // namespace
}  // namespace uwsim
