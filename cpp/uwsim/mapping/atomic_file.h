#pragma once

#include <string>
#include <string_view>

namespace uwsim {

/// The whole of a regular file. Throws FileError naming the path and the system's reason.
std::string read_whole_file(const std::string& path);

/// Writes to a temporary name beside the target, flushes it to the disk and renames it: whatever interrupts, the old
/// file or the new one is there, never half of one. On failure nothing is left behind and FileError names the path and
/// the system's reason. A link is followed; what exists and is no regular file (a folder, a device) is refused.
void write_file_atomically(const std::string& path, std::string_view bytes);

}  // namespace uwsim
