#include "uwsim/sim/saved_state_format.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::string_view kMagic = "uwsim state\n";
/// The version of the format of a saved state, as defined by this file and by every `exchange_state`. A new version
/// makes users' existing states unreadable, so increase it only if the old bytes cannot be converted to the new form.
constexpr std::uint64_t kVersion = 1;

/// FNV-1a, 64 bits: detects damage, not forgery.
std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t sum = 14695981039346656037u;
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return sum;
}

void append(std::string& to, std::uint64_t value) { to.append(reinterpret_cast<const char*>(&value), sizeof value); }

void append(std::string& to, const std::string& text) {
  append(to, static_cast<std::uint64_t>(text.size()));
  to += text;
}

std::string_view read_bytes(std::string_view& from, std::uint64_t size) {
  require(size <= from.size(), "state", "truncated", "must be as long as it was saved");
  const std::string_view bytes = from.substr(0, size);
  from.remove_prefix(size);
  return bytes;
}

std::uint64_t read_number(std::string_view& from) {
  std::uint64_t value = 0;
  std::memcpy(&value, read_bytes(from, sizeof value).data(), sizeof value);
  return value;
}

std::string_view read_text(std::string_view& from) { return read_bytes(from, read_number(from)); }

struct Content {
  std::string_view scenario, build, state;
};

/// Parses a saved state. Throws unless it is complete, undamaged and of a version that this build can read.
Content content_of(std::string_view bytes) {
  require(bytes.substr(0, kMagic.size()) == kMagic, "state", "foreign", "must be bytes that save_state returned");
  bytes.remove_prefix(kMagic.size());
  const std::uint64_t size = read_number(bytes), sum = read_number(bytes);
  require(size == bytes.size(), "state", size < bytes.size() ? "too long" : "truncated",
          "must be as long as it was saved");
  require(sum == checksum(bytes), "state", "damaged", "its checksum must match its content");
  const std::uint64_t version = read_number(bytes);
  require(
      version == kVersion, "state.version", version,
      "must be " + std::to_string(kVersion) + ": another version of uwsim saved it, in a format that this one lacks");
  const std::string_view scenario = read_text(bytes), build = read_text(bytes);
  return {scenario, build, bytes};
}

}  // namespace

std::string wrapped_state(std::string_view state, const StateOrigin& origin) {
  std::string content;
  append(content, kVersion);
  append(content, origin.scenario);
  append(content, origin.build);
  content += state;
  std::string bytes(kMagic);
  append(bytes, static_cast<std::uint64_t>(content.size()));
  append(bytes, checksum(content));
  return bytes + content;
}

std::string_view unwrapped_state(std::string_view bytes, const StateOrigin& origin) {
  const Content content = content_of(bytes);
  require(content.scenario == origin.scenario, "state.scenario", content.scenario,
          "must be " + origin.scenario + ": it was saved by another scenario, seed or vehicle");
  return content.state;
}

std::string saved_build(std::string_view bytes) { return std::string(content_of(bytes).build); }

}  // namespace uwsim
