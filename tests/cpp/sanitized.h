#pragma once

namespace uwsim {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How many of `count` random cases a test tries. AddressSanitizer and ThreadSanitizer make code 10 to 50 times as
/// slow; a tenth of the cases walks the same code there, and whether results are right is shown without a sanitizer.
constexpr int cases(int count) { return kSanitized ? count / 10 : count; }

}  // namespace uwsim
