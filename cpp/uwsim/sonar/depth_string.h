#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The text of the published `depthArray` topic: every beam's range in metres, each followed by the letter a:
/// "12.31a12.3a55a". A number is C#'s default text of a float32, format "G7" as Unity's runtime writes it: seven
/// significant digits, a tie rounded away from zero, no trailing zeros; with an exponent of at least two digits
/// ("1E-05", "1.234568E+07") where the decimal exponent is below -4 or above 6. Always with a point, whatever the
/// locale.
namespace uwsim {

/// ranges_m: one a beam, in [0, range_max_m], or infinity for a beam without echo, which carries range_max_m.
/// Throws InvalidValue that names the beam on anything else.
std::string encode_depth_string(std::span<const float> ranges_m, double range_max_m);

/// As published, a float32 value greater than range_limit_m (54.9 or 94.9) is no echo and becomes infinity.
/// Throws InvalidValue that names the beam, quotes the text and says the rule unless there are exactly `beams` values,
/// each a plain decimal number that is not negative and fits float32, and nothing else.
std::vector<float> decode_depth_string(std::string_view text, std::size_t beams, double range_limit_m);

}  // namespace uwsim
