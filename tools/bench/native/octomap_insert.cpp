// Stock OctoMap's insertPointCloud, with which `uwsim bench mapping` compares the brick engine.
// Usage: octomap_insert SCANS RESOLUTION_M MAX_RANGE_M eager|lazy. SCANS holds for each scan: its number of points
// (int32), its origin (three float32) and its points (three float32 each). Prints the processor seconds and the wall
// seconds per scan. With `lazy` the updateInnerOccupancy that lazy insertion needs at the end is not counted.
#include <octomap/OcTree.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <vector>

// The tree's code is Debian's, linked from its archives.
extern template class octomap::OcTreeDataNode<float>;
extern template class octomap::OcTreeBaseImpl<octomap::OcTreeNode, octomap::AbstractOccupancyOcTree>;
extern template class octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

int main(int count, char** arguments) {
  if (count != 5) {
    std::fprintf(stderr, "usage: octomap_insert SCANS RESOLUTION_M MAX_RANGE_M eager|lazy\n");
    return 2;
  }
  std::ifstream file(arguments[1], std::ios::binary);
  octomap::OcTree tree(std::atof(arguments[2]));
  const double max_range_m = std::atof(arguments[3]);
  const bool lazy = std::strcmp(arguments[4], "lazy") == 0;
  std::clock_t processor{};
  std::chrono::steady_clock::duration wall{};
  int scans = 0, points = 0;
  float origin[3];
  while (file.read(reinterpret_cast<char*>(&points), sizeof points) &&
         file.read(reinterpret_cast<char*>(origin), sizeof origin)) {
    std::vector<float> rows(3 * static_cast<std::size_t>(points));
    file.read(reinterpret_cast<char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(float)));
    octomap::Pointcloud cloud;
    for (std::size_t i = 0; i < rows.size(); i += 3) cloud.push_back(rows[i], rows[i + 1], rows[i + 2]);
    const std::clock_t processor_start = std::clock();
    const auto wall_start = std::chrono::steady_clock::now();
    tree.insertPointCloud(cloud, {origin[0], origin[1], origin[2]}, max_range_m, lazy);
    processor += std::clock() - processor_start;
    wall += std::chrono::steady_clock::now() - wall_start;
    ++scans;
  }
  if (scans == 0) {
    std::fprintf(stderr, "octomap_insert: '%s': no scans\n", arguments[1]);
    return 1;
  }
  std::printf("%.9g %.9g\n", static_cast<double>(processor) / CLOCKS_PER_SEC / scans,
              std::chrono::duration<double>(wall).count() / scans);
  return 0;
}
