#include "uwsim/mapping/bricks/spill_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "uwsim/core/check.h"

namespace uwsim::bricks {
namespace {

constexpr std::uint32_t kReservedMin = 512;

[[noreturn]] void fail(const std::string& folder, const std::string& reason) {
  throw FileError("'" + folder + "': the map's parts that leave memory cannot be kept there: " + reason);
}

/// Creates a file without a name if the file system supports that; otherwise, creates a named file and unlinks it
/// immediately.
int open_nameless(const std::string& folder) {
#ifdef O_TMPFILE
  const int fd = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC | O_EXCL, 0600);
  if (fd >= 0) return fd;
#endif
  std::string name = folder + "/.uwsim-map-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

}  // namespace

SpillFile::SpillFile(const std::string& folder) : folder_(folder) {
  if (folder_.empty()) {
    std::error_code error;
    folder_ = std::filesystem::temp_directory_path(error).string();
    if (error) fail("", error.message());
  }
  fd_ = open_nameless(folder_);
  if (fd_ < 0) fail(folder_, std::strerror(errno));
}

SpillFile::~SpillFile() { ::close(fd_); }

SpillFile::Extent SpillFile::write(std::span<const std::byte> bytes) {
  const std::uint32_t reserved = std::bit_ceil(std::max(static_cast<std::uint32_t>(bytes.size()), kReservedMin));
  std::vector<std::uint64_t>& free = free_[reserved];
  const bool reused = !free.empty();
  const Extent extent{reused ? free.back() : end_, static_cast<std::uint32_t>(bytes.size()), reserved};
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::pwrite(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(extent.offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail(folder_, n < 0 ? std::strerror(errno) : "nothing was written");
    done += static_cast<std::size_t>(n);
  }
  if (reused) {
    free.pop_back();
  } else {
    end_ += reserved;
  }
  return extent;
}

void SpillFile::read(const Extent& extent, std::span<std::byte> bytes) const {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(extent.offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail(folder_, n < 0 ? std::strerror(errno) : "the file has become shorter");
    done += static_cast<std::size_t>(n);
  }
}

void SpillFile::release(const Extent& extent) { free_[extent.reserved].push_back(extent.offset); }

}  // namespace uwsim::bricks
