#pragma once

namespace uwsim {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Returns the number of random cases out of `count` for a test to run. AddressSanitizer and ThreadSanitizer make code
/// 10 to 50 times slower; a tenth of the cases covers the same code, and correctness is checked without a sanitizer.
constexpr int cases(int count) { return kSanitized ? count / 10 : count; }

}  // namespace uwsim
