#include "uwsim/sonar/depth_string.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr char kSeparator = 'a';
/// A float32 in G7 format takes up to 13 characters including its separator; other writers may use more digits, up to
/// this limit.
constexpr std::size_t kLettersMax = 32;
constexpr std::size_t kWrittenMax = 16;
constexpr std::size_t kBeamsMax = 1'000'000;

constexpr int kDigits = 7;
constexpr double kMinPlain = 1e-4, kMaxPlain = 1e6;
constexpr std::array<double, kDigits + 4> kTens = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10};

/// Like write_any_g7, for values in [kMinPlain, kMaxPlain). Four times as fast. A float32 has 24 significant bits, and
/// 10^10 = 2^10 5^10 has another 24. Their product is therefore exact in a double, and so is the sum after one half has
/// been added for rounding.
char* write_plain_g7(char* out, float value) {
  int exponent = value < 1 ? -4 : 0;  // of the first digit
  while (value >= (exponent < -1 ? 1 / kTens[static_cast<std::size_t>(-exponent - 1)]
                                 : kTens[static_cast<std::size_t>(exponent + 1)]))
    ++exponent;
  auto digits = static_cast<std::uint32_t>(value * kTens[static_cast<std::size_t>(kDigits - 1 - exponent)] + 0.5);
  if (digits == 10'000'000) {  // rounded up to the next power
    digits = 1'000'000;
    ++exponent;
  }
  char text[kDigits];
  std::uint32_t high = digits / 10'000, low = digits % 10'000;  // two chains of divisions, which run in parallel
  for (int k = 2; k >= 0; --k, high /= 10) text[k] = static_cast<char>('0' + high % 10);
  for (int k = kDigits - 1; k >= 3; --k, low /= 10) text[k] = static_cast<char>('0' + low % 10);
  int count = kDigits;
  while (count > 1 && count > exponent + 1 && text[count - 1] == '0') --count;
  if (exponent < 0) {
    *out++ = '0';
    *out++ = '.';
    out = std::fill_n(out, -exponent - 1, '0');
    return std::copy_n(text, count, out);
  }
  const int whole = exponent + 1;
  out = std::copy_n(text, whole, out);
  if (count == whole) return out;
  *out++ = '.';
  return std::copy(text + whole, text + count, out);
}

/// Writes a non-negative number in C#'s format. C's %.7g follows the same rules except for the capital E and for ties,
/// which it rounds to even. Using the next larger double breaks ties away from zero; the increment is far below the
/// seventh digit.
char* write_any_g7(char* out, float value) {
  double nudged = value;
  if (value != 0) nudged = std::nextafter(nudged, std::numeric_limits<double>::infinity());
  char* end = std::to_chars(out, out + kWrittenMax, std::abs(nudged), std::chars_format::general, 7).ptr;
  std::replace(out, end, 'e', 'E');
  return end;
}

char* write_g7(char* out, float value) {
  return value >= kMinPlain && value < kMaxPlain ? write_plain_g7(out, value) : write_any_g7(out, value);
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

[[noreturn]] void refuse(std::size_t beam, std::string_view text, const std::string& rule) {
  std::string quoted = "'";
  for (const char c : text.substr(0, 24)) quoted += c >= ' ' && c <= '~' ? c : '?';
  quoted += text.size() > 24 ? "...'" : "'";
  throw InvalidValue("depth_string[" + std::to_string(beam) + "] = " + quoted + ": " + rule);
}

/// Parses up to seven digits with a point among them, as almost all ranges are written, into `value`; returns whether
/// the text is of this form. The digits and the power of ten are exact in float32, so their quotient is rounded once
/// and equals the result of from_chars.
bool parse_plain(std::string_view text, float& value) {
  if (text.size() < 3 || text.size() > kDigits + 1 || !is_digit(text.front()) || !is_digit(text.back())) return false;
  std::uint32_t digits = 0;
  std::size_t point = 0;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (is_digit(text[k])) {
      digits = 10 * digits + static_cast<std::uint32_t>(text[k] - '0');
    } else if (text[k] == '.' && point == 0) {
      point = k;
    } else {
      return false;
    }
  }
  if (point == 0) return false;
  value = static_cast<float>(digits) / static_cast<float>(kTens[text.size() - 1 - point]);
  return true;
}

float parse_range(std::string_view text, std::size_t beam) {
  float value = 0;
  if (parse_plain(text, value)) return value;
  // Check for digits at both ends, because from_chars also accepts "inf", ".5", "5." and "-1".
  const bool plain = !text.empty() && is_digit(text.front()) && is_digit(text.back());
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (!plain || error == std::errc::invalid_argument || end != text.data() + text.size()) {
    refuse(beam, text, "must be a decimal number of metres, at least 0");
  }
  if (error == std::errc::result_out_of_range) refuse(beam, text, "must fit a float32");
  return value;
}

}  // namespace

std::string encode_depth_string(std::span<const float> ranges_m, double range_max_m) {
  require(range_max_m > 0 && range_max_m <= std::numeric_limits<float>::max(), "sonar.range_max_m", range_max_m,
          "must be positive and fit a float32");
  std::string text(kWrittenMax * ranges_m.size(), '\0');
  char* out = text.data();
  for (std::size_t beam = 0; beam < ranges_m.size(); ++beam) {
    const float range_m = ranges_m[beam];
    if (!(range_m >= 0 && (range_m <= range_max_m || std::isinf(range_m)))) {
      require(false, "ranges_m[" + std::to_string(beam) + "]", range_m,
              "must be in [0, " + printed(range_max_m) + "] m, or inf for a beam without echo");
    }
    out = write_g7(out, std::isinf(range_m) ? static_cast<float>(range_max_m) : range_m);
    *out++ = kSeparator;
  }
  text.resize(static_cast<std::size_t>(out - text.data()));
  return text;
}

std::vector<float> decode_depth_string(std::string_view text, std::size_t beams, double range_limit_m) {
  require(range_limit_m > 0, "sonar.range_limit_m", range_limit_m, "must be positive");
  require(beams <= kBeamsMax, "sonar.beams", beams, "must be at most 1000000");
  require(
      text.size() <= beams * kLettersMax, "depth_string.size", text.size(),
      "must be at most " + std::to_string(beams * kLettersMax) + " letters for " + std::to_string(beams) + " beams");
  const std::string count_rule = "the text must hold " + std::to_string(beams) + " values, each followed by 'a'";
  std::vector<float> ranges_m;
  ranges_m.reserve(beams);
  while (!text.empty()) {
    const std::size_t end = text.find(kSeparator);
    const std::size_t beam = ranges_m.size();
    if (beam == beams || end == std::string_view::npos) refuse(beam, text, count_rule);
    const float range_m = parse_range(text.substr(0, end), beam);
    ranges_m.push_back(range_m > range_limit_m ? std::numeric_limits<float>::infinity() : range_m);
    text.remove_prefix(end + 1);
  }
  if (ranges_m.size() != beams) refuse(ranges_m.size(), "", count_rule);
  return ranges_m;
}

}  // namespace uwsim
