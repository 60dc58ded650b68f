#pragma once

namespace uwsim {

/// While it lives, what this thread prints to C's stderr is dropped; other threads' text goes where it always goes.
/// For libraries that print what is no one's business. C++'s std::cerr is not concerned.
class QuietStderr {
 public:
  QuietStderr();
  ~QuietStderr();
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;
};

}  // namespace uwsim
