#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// Returns the contents of a regular file. Throws FileError naming the path and the system's reason.
std::string read_whole_file(const std::string& path);

/// A file that replaces another only when it is complete. It is written under a temporary name next to the target;
/// commit() flushes it to disk and renames it. An interruption therefore leaves either the old file or the new one,
/// never a partial file, and without commit() nothing is left behind. A symbolic link is followed; a target that exists
/// but is not a regular file (a folder, a device) is refused. Throws FileError with the path and the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void append(std::string_view bytes);
  void commit();

 private:
  [[noreturn]] void fail(int error);

  std::string path_, target_, temporary_;
  int fd_ = -1;
};

/// Removes the temporary files of all files being written. For use when a process must end while other threads are
/// writing.
void remove_unfinished_files();

/// Writes a whole file through an AtomicFile.
void write_file_atomically(const std::string& path, std::string_view bytes);

}  // namespace uwsim
