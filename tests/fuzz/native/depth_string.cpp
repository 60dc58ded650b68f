// The text of the depthArray topic: what is accepted is the same after it is written and read again.
#include <cmath>
#include <cstdlib>

#include "uwsim/core/check.h"
#include "uwsim/sonar/depth_string.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t beams = data[0] % 16;
  constexpr double kLimit_m = 54.9;
  std::vector<float> ranges_m;
  try {
    ranges_m = uwsim::decode_depth_string(text, beams, kLimit_m);
  } catch (const uwsim::InvalidValue&) {
    return 0;
  }
  if (ranges_m.size() != beams) std::abort();
  for (const float range_m : ranges_m) {
    if (!(range_m >= 0)) std::abort();
  }
  const std::string written = uwsim::encode_depth_string(ranges_m, 55);
  const std::vector<float> again = uwsim::decode_depth_string(written, beams, kLimit_m);
  if (uwsim::encode_depth_string(again, 55) != written) std::abort();
  return 0;
}
