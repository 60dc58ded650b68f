#pragma once

#include <array>
#include <ostream>
#include <streambuf>

#include "uwsim/mapping/atomic_file.h"

namespace uwsim {

/// An ostream that writes to an AtomicFile, for libraries that write to streams. A FileError propagates through the
/// library.
class AtomicFileStream : private std::streambuf, public std::ostream {
 public:
  explicit AtomicFileStream(AtomicFile& file) : std::ostream(this), file_(file) {
    setp(bytes_.data(), bytes_.data() + bytes_.size());
    exceptions(std::ios::badbit);  // makes the ostream rethrow exceptions from overflow()
  }

 private:
  int overflow(int next) override {
    sync();
    if (next != std::streambuf::traits_type::eof()) sputc(static_cast<char>(next));
    return 0;
  }
  int sync() override {
    file_.append({pbase(), static_cast<std::size_t>(pptr() - pbase())});
    setp(bytes_.data(), bytes_.data() + bytes_.size());
    return 0;
  }

  AtomicFile& file_;
  std::array<char, 1 << 16> bytes_;
};

}  // namespace uwsim
