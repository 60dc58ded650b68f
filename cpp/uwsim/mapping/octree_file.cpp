#include "uwsim/mapping/octree_file.h"

#include <charconv>
#include <cmath>
#include <cstring>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::string_view kBinaryTitle = "# Octomap OcTree binary file";
constexpr std::string_view kFullTitle = "# Octomap OcTree file";

[[noreturn]] void refuse(std::string_view name, const std::string& rule) {
  throw InvalidValue("map '" + std::string(name) + "': " + rule);
}

/// Makes text from a file printable on one line of a message.
std::string quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > 40 ? "...'" : "'");
}

template <typename Number>
Number parse_number(std::string_view text, std::string_view key, std::string_view name) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    refuse(name, "header '" + std::string(key) + "' is " + quoted(text) + ", not a number");
  }
  return number;
}

std::string_view take_line(std::string_view bytes, std::size_t& at, std::string_view name) {
  const std::size_t end = bytes.find('\n', at);
  if (end == std::string_view::npos) refuse(name, "the header is cut short (no 'data' line)");
  const std::string_view line = bytes.substr(at, end - at);
  at = end + 1;
  return line;
}

OctreeFile parse_header(std::string_view bytes, std::string_view name) {
  OctreeFile file{MapFormat::bt, 0, 0, 0, {}};
  if (bytes.starts_with(kFullTitle)) {
    file.format = MapFormat::ot;
  } else if (!bytes.starts_with(kBinaryTitle)) {
    refuse(name, "not an OctoMap file (it must begin with '" + std::string(kBinaryTitle) + "' or '" +
                     std::string(kFullTitle) + "')");
  }
  std::size_t& at = file.body_offset;
  std::string_view id;
  bool has_size = false;
  for (std::string_view line; (line = take_line(bytes, at, name)) != "data";) {
    if (line.starts_with('#')) continue;
    const std::size_t space = line.find(' ');
    const std::string_view key = line.substr(0, space);
    const std::string_view value = space == std::string_view::npos ? std::string_view() : line.substr(space + 1);
    if (key == "id") {
      id = value;
    } else if (key == "size") {
      file.nodes = parse_number<std::uint64_t>(value, key, name);
      has_size = true;
    } else if (key == "res") {
      file.resolution_m = parse_number<double>(value, key, name);
    } else {
      refuse(name, "unknown header line " + quoted(line));
    }
  }
  if (id != "OcTree") refuse(name, "holds a tree of type " + quoted(id) + ", not 'OcTree'");
  if (!has_size) refuse(name, "the header has no 'size'");
  require_resolution(file.resolution_m, "map '" + std::string(name) + "': res");
  return file;
}

/// Walks the bytes of a tree and counts its nodes. Recursion is limited to the maximum depth of a tree.
class TreeCheck {
 public:
  TreeCheck(std::string_view bytes, std::size_t at, std::string_view name) : bytes_(bytes), at_(at), name_(name) {}

  /// Visits an inner node of a .bt that has already been counted. The tree must have a level below the node, and
  /// another one below its inner children.
  void binary_node(int depth) {
    const auto codes = take<std::uint16_t>();
    ++inner_nodes[static_cast<std::size_t>(depth)];
    if (codes == 0) refuse(name_, "damaged: an inner node without children");
    for (int child = 0; child < 8; ++child) nodes += code(codes, child) != 0;
    for (int child = 0; child < 8; ++child) {
      if (code(codes, child) == 3) binary_node(one_below(depth, kTreeDepth - 1));
    }
  }

  /// Visits a node of an .ot that has already been counted.
  void full_node(int depth) {
    if (!std::isfinite(take<float>())) refuse(name_, "damaged: a log-odds that is not finite");
    const auto flags = take<std::uint8_t>();
    inner_nodes[static_cast<std::size_t>(depth)] += flags != 0;
    if (depth == 0 && flags == 0) refuse(name_, "damaged: a root without children");
    for (int child = 0; child < 8; ++child) {
      if (!((flags >> child) & 1)) continue;
      ++nodes;
      full_node(one_below(depth, kTreeDepth));
    }
  }

  void expect_end() const {
    if (at_ != bytes_.size()) refuse(name_, std::to_string(bytes_.size() - at_) + " bytes follow the end of the tree");
  }

  std::uint64_t nodes = 1;
  std::array<std::uint64_t, kTreeDepth + 1> inner_nodes{};

 private:
  static unsigned code(unsigned codes, int child) { return (codes >> (2 * child)) & 3u; }

  int one_below(int depth, int deepest) const {
    if (depth == deepest) refuse(name_, "damaged: a tree deeper than 16 levels");
    return depth + 1;
  }

  template <typename Value>
  Value take() {
    if (bytes_.size() - at_ < sizeof(Value)) refuse(name_, "cut short: the tree does not end where the file does");
    Value value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(Value));
    at_ += sizeof(Value);
    return value;
  }

  std::string_view bytes_;
  std::size_t at_;
  std::string_view name_;
};

}  // namespace

OctreeFile check_octree_file(std::string_view bytes, std::string_view name) {
  OctreeFile file = parse_header(bytes, name);
  TreeCheck tree(bytes, file.body_offset, name);
  if (file.nodes == 0) {
    tree.expect_end();
    return file;
  }
  file.format == MapFormat::bt ? tree.binary_node(0) : tree.full_node(0);
  tree.expect_end();
  file.inner_nodes = tree.inner_nodes;
  if (tree.nodes != file.nodes) {
    refuse(name,
           "damaged: " + std::to_string(tree.nodes) + " nodes, but the header says " + std::to_string(file.nodes));
  }
  return file;
}

std::string octree_header(MapFormat format, std::uint64_t nodes, double resolution_m) {
  char digits[32];
  auto end = std::to_chars(digits, digits + sizeof digits, resolution_m, std::chars_format::general, 6).ptr;
  double read_back = 0;
  std::from_chars(digits, end, read_back);
  if (read_back != resolution_m) end = std::to_chars(digits, digits + sizeof digits, resolution_m).ptr;
  return std::string(format == MapFormat::bt ? kBinaryTitle : kFullTitle) +
         "\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid OcTree\nsize " +
         std::to_string(nodes) + "\nres " + std::string(digits, end) + "\ndata\n";
}

void require_resolution(double resolution_m, std::string_view path) {
  require(resolution_m >= 0.001 && resolution_m <= 1000, path, resolution_m, "must be in [0.001, 1000] m");
}

}  // namespace uwsim
