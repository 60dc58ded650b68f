#pragma once

namespace uwsim {

/// While an object of this class exists, text that its thread prints to C's stderr is discarded; output of other
/// threads is not. Meant for libraries that print progress. C++'s std::cerr is not affected.
class QuietStderr {
 public:
  QuietStderr();
  ~QuietStderr();
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;
};

}  // namespace uwsim
