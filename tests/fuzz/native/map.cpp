// .bt and .ot files: both engines accept the same ones, as the same map, and no file that is cut short.
#include <cstdlib>
#include <optional>

#include "uwsim/core/check.h"
#include "uwsim/mapping/occupancy_map.h"

namespace {

using namespace uwsim;

std::optional<OccupancyMap> read(std::string_view bytes, MapEngineKind engine) {
  MapOptions options;
  options.engine = engine;
  try {
    return OccupancyMap::from_bytes(bytes, "fuzz", Eigen::Vector3d::Zero(), options);
  } catch (const InvalidValue&) {
    return std::nullopt;
  }
}

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::optional<OccupancyMap> map = read(bytes, MapEngineKind::bricks);
  const std::optional<OccupancyMap> peer = read(bytes, MapEngineKind::octomap);
  require(map.has_value() == peer.has_value());
  if (!map) return 0;
  const std::string written = map->to_bytes(MapFormat::ot);
  require(peer->to_bytes(MapFormat::ot) == written);
  const std::optional<OccupancyMap> again = read(written, MapEngineKind::bricks);
  require(again && again->to_bytes(MapFormat::ot) == written);
  for (const std::size_t cut : {std::size_t{1}, size / 2}) {
    require(!read(bytes.substr(0, size - cut), MapEngineKind::bricks));
  }
  return 0;
}
