#include "uwsim/mapping/atomic_file.h"

#include <fcntl.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const char* what, const std::string& reason) {
  throw FileError("'" + path + "': cannot be " + what + ": " + reason);
}

[[noreturn]] void fail_to_write(const std::string& path, int error) { fail(path, "written", std::strerror(error)); }

void require_path(const std::string& path) {
  require(!path.empty(), "path", "''", "must name a file");
  require(path.find('\0') == std::string::npos, "path", path.c_str(), "must not hold a null character");
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// The file to replace. Symbolic links are resolved, so that a link remains a link.
fs::path real_target(const std::string& path) {
  require_path(path);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    if (fs::is_symlink(fs::symlink_status(path, error))) fail(path, "written", "it is a link to nothing");
    return path;
  }
  if (error) fail(path, "written", error.message());
  if (!fs::is_regular_file(status)) fail(path, "written", "it is not a regular file");
  fs::path target = fs::canonical(path, error);
  if (error) fail(path, "written", error.message());
  return target;
}

/// The process ID in the name keeps concurrent programs from using the same file; O_EXCL protects existing files.
std::pair<int, fs::path> create_beside(const fs::path& target, const std::string& path) {
  for (int attempt = 0;; ++attempt) {
    std::ostringstream name;
    name << ".uwsim-" << ::getpid() << '-' << attempt << ".tmp";
    const fs::path temporary = target.parent_path() / name.str();
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0) {
      // Marks the file as ours, as python/uwsim/base/own_files.py does; not all file systems can.
      constexpr std::string_view mark = "unfinished";
      (void)::fsetxattr(fd, "user.uwsim", mark.data(), mark.size(), 0);
      return {fd, temporary};
    }
    if (errno != EEXIST || attempt == 1000) fail_to_write(path, errno);
  }
}

/// The temporary names of all files being written, each with the process that writes it, because a forked child
/// inherits its parent's list.
struct Unfinished {
  std::mutex mutex;
  std::map<std::string, pid_t> writers;
};

/// Never destroyed, since threads may write until the process ends.
Unfinished& unfinished() {
  static auto* const all = new Unfinished;
  return *all;
}

/// Flushes the target's folder, because a rename is only durable after that. File systems that do not support this
/// ignore it.
void flush_folder(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

std::string read_whole_file(const std::string& path) {
  require_path(path);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) fail(path, "read", "no such file");
  if (error) fail(path, "read", error.message());
  if (!fs::is_regular_file(status)) fail(path, "read", "it is not a regular file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "read", std::strerror(errno));
  std::string bytes(fs::file_size(path, error), '\0');
  if (error) fail(path, "read", error.message());
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.bad()) fail(path, "read", std::strerror(errno));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

void remove_unfinished_files() {
  const std::scoped_lock lock(unfinished().mutex);
  for (const auto& [name, writer] : unfinished().writers) {
    if (writer == ::getpid()) ::unlink(name.c_str());
  }
}

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  const fs::path target = real_target(path);
  const std::scoped_lock lock(unfinished().mutex);
  const auto [fd, temporary] = create_beside(target, path);
  unfinished().writers[temporary.string()] = ::getpid();
  fd_ = fd;
  target_ = target.string();
  temporary_ = temporary.string();
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) {
    ::close(fd_);
    ::unlink(temporary_.c_str());
  }
  const std::scoped_lock lock(unfinished().mutex);
  unfinished().writers.erase(temporary_);
}

void AtomicFile::fail(int error) { fail_to_write(path_, error); }

void AtomicFile::append(std::string_view bytes) {
  if (!write_all(fd_, bytes)) fail(errno);
}

void AtomicFile::commit() {
  if (::fsync(fd_) != 0) fail(errno);
  const bool is_closed = ::close(std::exchange(fd_, -1)) == 0;  // some disk errors are reported only here
  if (!is_closed || ::rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary_.c_str());
    fail(error);
  }
  flush_folder(target_);
}

void write_file_atomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.append(bytes);
  file.commit();
}

}  // namespace uwsim
