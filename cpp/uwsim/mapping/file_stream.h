#pragma once

#include <array>
#include <ostream>
#include <streambuf>

#include "uwsim/mapping/atomic_file.h"

namespace uwsim {

/// An ostream, for libraries that write to one, into an AtomicFile, whose FileError comes through.
class FileStream : private std::streambuf, public std::ostream {
 public:
  explicit FileStream(AtomicFile& file) : std::ostream(this), file_(file) {
    setp(bytes_.data(), bytes_.data() + bytes_.size());
    exceptions(std::ios::badbit);  // rethrows what overflow() throws
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
