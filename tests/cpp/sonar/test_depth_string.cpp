#include "uwsim/sonar/depth_string.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr double kFloatMax = std::numeric_limits<float>::max();

std::string text_of(float value) { return encode_depth_string({&value, 1}, kFloatMax); }

std::string refusal_of(const std::string& text, std::size_t beams = 2) {
  try {
    decode_depth_string(text, beams, 54.9);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "";
}

TEST(DepthString, WritesNumbersAsCSharpDoes) {
  const std::pair<float, const char*> published[] = {
      {0.0f, "0a"},
      {-0.0f, "0a"},
      {12.31f, "12.31a"},
      {12.3f, "12.3a"},
      {55.0f, "55a"},
      {0.1f, "0.1a"},
      {0.0001f, "0.0001a"},
      {0.00001f, "1E-05a"},
      {1.5e-10f, "1.5E-10a"},
      {1234567.0f, "1234567a"},
      {12345678.0f, "1.234568E+07a"},
      {1e7f, "1E+07a"},
      {3.40282347e38f, "3.402823E+38a"},
  };
  for (const auto& [value, text] : published) EXPECT_EQ(text_of(value), text);
}

TEST(DepthString, RoundsTiesAwayFromZero) {
  EXPECT_EQ(text_of(10.015625f), "10.01563a");  // rounding to even would give 10.01562
  EXPECT_EQ(text_of(10.046875f), "10.04688a");
  EXPECT_EQ(text_of(1234566.5f), "1234567a");  // rounding to even would give 1234566
}

/// Formats by the C library's %.7g of the next larger double, so that ties round away from zero.
std::string by_printf(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7ga", std::nextafter(static_cast<double>(value), 1e300));
  return text;
}

TEST(DepthString, AgreesWithPrintfOnEveryKindOfFloat) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> exponent(-4.2f, 6.2f);
  for (int k = 0; k < 300'000; ++k) {
    const float value = std::pow(10.0f, exponent(random));
    if (value >= 1e-4f && value < 9.9e6f) {
      ASSERT_EQ(text_of(value), by_printf(value));
    }
  }
  for (const float power :
       {1e-4f, 1e-3f, 1e-2f, 0.1f, 1.0f, 10.0f, 100.0f, 1e3f, 1e4f, 1e5f, 1e6f, 8.5f, 54.9f, 95.0f}) {
    float value = power;
    for (int k = 0; k < 200; ++k) value = std::nextafter(value, 0.0f);
    for (int k = 0; k < 400; ++k, value = std::nextafter(value, kInf)) {
      if (value >= 1e-4f) {
        ASSERT_EQ(text_of(value), by_printf(value));
      }
    }
  }
  for (std::uint32_t k = 1; k < 4'000'000; k += 7) {  // includes ties and all short decimals at a sonar's resolution
    const float value = static_cast<float>(k) / 65536;
    if (value >= 1e-4f) {
      ASSERT_EQ(text_of(value), by_printf(value));
    }
  }
}

TEST(DepthString, ReadsBackWithinHalfOfTheSeventhDigit) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 54.8f);
  std::vector<float> ranges_m(513);
  for (float& range_m : ranges_m) range_m = uniform(random);
  const std::string text = encode_depth_string(ranges_m, 55);
  const std::vector<float> back_m = decode_depth_string(text, 513, 54.9);
  for (std::size_t i = 0; i < ranges_m.size(); ++i) EXPECT_NEAR(back_m[i], ranges_m[i], 0.51e-5 + 4e-6);
  EXPECT_EQ(encode_depth_string(back_m, 55), text);
}

TEST(DepthString, ABeamWithoutEchoIsWrittenAsTheMaximumRangeAndReadAsInfinite) {
  EXPECT_EQ(encode_depth_string(std::vector<float>{kInf, 1.5f}, 55), "55a1.5a");
  EXPECT_EQ(decode_depth_string("55a1.5a", 2, 54.9), (std::vector<float>{kInf, 1.5f}));
}

TEST(DepthString, ReadsDecimalsAsTheCLibraryDoes) {
  std::mt19937 random(2);
  const auto up_to = [&](unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(random); };
  for (int k = 0; k < 20'000; ++k) {
    std::string text(1 + up_to(5), '0');
    for (char& letter : text) letter = static_cast<char>('0' + up_to(9));
    if (up_to(3) > 0) text += '.' + std::to_string(up_to(up_to(1) ? 99'999'999 : 999));
    EXPECT_EQ(decode_depth_string(text + 'a', 1, kFloatMax).front(), std::strtof(text.c_str(), nullptr)) << text;
  }
}

TEST(DepthString, TheLimitItselfIsNoEcho) {
  // The float32 nearest to 54.9 is greater than 54.9; the published decoder compares with that float32.
  EXPECT_EQ(decode_depth_string("54.9a54.90001a54.89999a", 3, 54.9), (std::vector<float>{kInf, kInf, 54.89999f}));
}

TEST(DepthString, RefusesRangesOutOfRange) {
  for (const float bad : {std::nanf(""), -1.0f, -kInf, 55.1f}) {
    EXPECT_THROW(encode_depth_string(std::vector<float>{bad}, 55), InvalidValue);
  }
}

TEST(DepthString, AnErrorNamesBeamTextAndRule) {
  EXPECT_EQ(refusal_of("1a2x3a"), "depth_string[1] = '2x3': must be a decimal number of metres, at least 0");
  EXPECT_EQ(refusal_of("1a2"), "depth_string[1] = '2': the text must hold 2 values, each followed by 'a'");
}

TEST(DepthString, RefusesEverythingButPlainDecimals) {
  for (const char* bad :
       {"",       "a",      "1a",          "1aa",   "1a2a3a", "1a2a ",  "1a2ax",   " 1a2a",   "1a-2a",    "1a+2a",
        "1anana", "1ainfa", "1aInfinitya", "1a.5a", "1a5.a",  "1a1,5a", "1a0x1Pa", "1a1E99a", "1a1E-99a", "1a1Ea"}) {
    EXPECT_NE(refusal_of(bad), "") << bad;
  }
  EXPECT_LT(refusal_of("1a" + std::string(60, '7')).size(), 120u);
  EXPECT_NE(refusal_of(std::string(1'000'000, '1')), "");
  EXPECT_NE(refusal_of(std::string("1a2\0a", 5)), "");
}

}  // namespace
}  // namespace uwsim
