#ifndef _GNU_SOURCE
#define _GNU_SOURCE  // fopencookie
#endif
#include "uwsim/mapping/quiet_stderr.h"

#include <stdio.h>
#include <unistd.h>

#include <mutex>

namespace uwsim {
namespace {

thread_local int quiet = 0;  ///< number of QuietStderr objects in this thread

ssize_t write_unless_quiet(void*, const char* text, size_t size) {
  return quiet > 0 ? static_cast<ssize_t>(size) : ::write(STDERR_FILENO, text, size);
}

/// Returns a stream that replaces stderr, which is a variable in glibc. The stream is never closed, since another
/// thread may be about to print to it.
FILE* filter() {
  static FILE* const stream = [] {
    cookie_io_functions_t functions{};
    functions.write = write_unless_quiet;
    FILE* made = ::fopencookie(nullptr, "w", functions);
    if (made) ::setvbuf(made, nullptr, _IONBF, 0);
    return made;
  }();
  return stream;
}

std::mutex swapping;
int in_use = 0;  ///< number of QuietStderr objects in all threads
FILE* original = nullptr;

}  // namespace

QuietStderr::QuietStderr() {
  const std::scoped_lock lock(swapping);
  ++quiet;
  if (in_use++ > 0 || !filter()) return;
  original = stderr;
  stderr = filter();
}

QuietStderr::~QuietStderr() {
  const std::scoped_lock lock(swapping);
  --quiet;
  if (--in_use > 0 || !original) return;
  stderr = original;
  original = nullptr;
}

}  // namespace uwsim
