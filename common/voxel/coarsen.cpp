#include "common/voxel/coarsen.h"

namespace periplus::voxel {
namespace {

// How many of each 2 x 2 x 2 voxels are set: of z pairs 0 and 2 (`even`) and 1 and 3 (`odd`) in fields of four bits, in the rows
// of even y.
struct Sums {
  std::uint64_t even = 0, odd = 0;

  Sums(std::uint64_t x0, std::uint64_t x1) {
    for (std::uint64_t word : {x0, x1}) {
      const std::uint64_t z = (word & kPairs) + (word >> 1 & kPairs);  // fields of two bits
      const std::uint64_t e = z & kFields, o = z >> 2 & kFields;
      even += e + (e >> 8);
      odd += o + (o >> 8);
    }
  }
  // Of the pair of rows y / 2, z / 2 = 0 .. 3.
  int at(int y, int z) const { return static_cast<int>((z % 2 == 0 ? even : odd) >> (16 * y + z / 2 * 4) & 15); }

 private:
  static constexpr std::uint64_t kPairs = 0x5555555555555555ull, kFields = 0x3333333333333333ull;
};

}  // namespace

OccupancyGrid coarsen(const OccupancyGrid& grid) {
  const GridGeometry& fine = grid.geometry();
  GridGeometry g = fine;
  g.voxel_size = 2 * fine.voxel_size;
  g.size = (fine.size.array() + 1) / 2;
  OccupancyGrid coarse(g);
  coarse.revision = grid.revision;
  const Eigen::Vector3i from = fine.bricks(), to = g.bricks();
  std::fill(coarse.occupied().begin(), coarse.occupied().end(), 0);
  for (int bx = 0; bx < from.x(); ++bx) {
    for (int by = 0; by < from.y(); ++by) {
      for (int bz = 0; bz < from.z(); ++bz) {
        const std::size_t base = ((static_cast<std::size_t>(bx) * from.y() + by) * from.z() + bz) * 8;
        const std::size_t out = ((static_cast<std::size_t>(bx / 2) * to.y() + by / 2) * to.z() + bz / 2) * 8 + bx % 2 * 4;
        for (int x = 0; x < 4; ++x) {
          const std::size_t i = base + 2 * x, j = i + 1;
          if ((grid.occupied()[i] | grid.occupied()[j]) == 0) continue;
          const Sums occupied(grid.occupied()[i], grid.occupied()[j]), known(grid.known()[i], grid.known()[j]),
              environment(grid.environment()[i], grid.environment()[j]);
          for (int y = 0; y < 4; ++y) {
            for (int z = 0; z < 4; ++z) {
              const int all = occupied.at(y, z);
              if (all < 4) continue;
              const std::uint64_t bit = 1ull << ((by % 2 * 4 + y) * 8 + bz % 2 * 4 + z);
              coarse.occupied()[out + x] |= bit;
              if (2 * environment.at(y, z) >= all) coarse.environment()[out + x] |= bit;
              else if (2 * (known.at(y, z) + environment.at(y, z)) > all) coarse.known()[out + x] |= bit;
            }
          }
        }
      }
    }
  }
  return coarse;
}

}  // namespace periplus::voxel
