#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The text of the published `depthArray` topic: the range of every beam in metres, each followed by the letter a, such
/// as "12.31a12.3a55a". Numbers are formatted like a float32 in C# by default ("G7" in Unity's runtime): seven
/// significant digits, ties rounded away from zero, no trailing zeros, and an exponent of at least two digits ("1E-05",
/// "1.234568E+07") if the decimal exponent is below -4 or above 6. The decimal separator is a point in any locale.
namespace uwsim {

/// ranges_m: one per beam, in [0, range_max_m], or infinity for no echo, which is written as range_max_m. Throws
/// InvalidValue naming the beam for any other value.
std::string encode_depth_string(std::span<const float> ranges_m, double range_max_m);

/// As in the paper, a float32 value greater than range_limit_m (54.9 or 94.9) means no echo and becomes infinity.
/// Throws InvalidValue naming the beam, the text and the rule unless the text consists of exactly `beams` values, each
/// a plain non-negative decimal number that fits in a float32.
std::vector<float> decode_depth_string(std::string_view text, std::size_t beams, double range_limit_m);

}  // namespace uwsim
