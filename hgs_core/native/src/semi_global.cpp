// Along each of eight directions a depth costs what it matches, and a change of depth something more: little for a step to
// the next depth, as on a slanted surface, and much for a jump, less where the picture has an edge.
#include "semi_global.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace hgs {
namespace {

constexpr int kStep = 82;         // cost of a step to the next depth: 0.04
constexpr float kJump = 1024.0f;  // of a jump where the picture is even: 0.5
constexpr float kEdge = 30.0f;    // times the difference of grey, by which a jump there is cheaper
constexpr uint16_t kFar = 1 << 14;  // more than any path costs

// One row of pixels with the costs of the paths that end there; a place more on either side of the depths.
class PathRow {
 public:
  PathRow(int width, int depths) : stride_(depths + 2), paths_(static_cast<size_t>(width) * stride_, kFar), least_(width) {}

  uint16_t *at(int x) { return paths_.data() + static_cast<size_t>(x) * stride_ + 1; }
  uint16_t &least(int x) { return least_[x]; }

 private:
  int stride_;
  std::vector<uint16_t> paths_;
  std::vector<uint16_t> least_;
};

uint16_t jump_between(float a, float b) {
  return static_cast<uint16_t>(std::max(kJump / (1.0f + kEdge * std::fabs(a - b)), 1.5f * kStep));
}

// Go on by a pixel: `before` are the costs of the path's last pixel, of which `least` is the smallest.
uint16_t go_on(const uint16_t *cost, const uint16_t *before, uint16_t least, uint16_t jump, int depths, uint16_t *path,
               uint16_t *sum) {
  const uint16_t most = static_cast<uint16_t>(least + jump);
  uint16_t smallest = UINT16_MAX;
  for (int d = 0; d < depths; ++d) {
    const uint16_t beside = static_cast<uint16_t>(std::min(before[d - 1], before[d + 1]) + kStep);
    const uint16_t from = std::min(std::min(before[d], beside), most);
    const uint16_t now = static_cast<uint16_t>(cost[d] + from - least);
    path[d] = now;
    sum[d] = static_cast<uint16_t>(sum[d] + now);
    smallest = std::min(smallest, now);
  }
  return smallest;
}

uint16_t begin(const uint16_t *cost, int depths, uint16_t *path, uint16_t *sum) {
  uint16_t smallest = UINT16_MAX;
  for (int d = 0; d < depths; ++d) {
    path[d] = cost[d];
    sum[d] = static_cast<uint16_t>(sum[d] + cost[d]);
    smallest = std::min(smallest, cost[d]);
  }
  return smallest;
}

}  // namespace

void semi_global(const uint16_t *costs, const float *grey, int width, int height, int depths, float *places,
                 float *matched) {
  std::vector<uint16_t> sums(static_cast<size_t>(width) * height * depths);
  // Down and to the right, then up and to the left: each pass has the paths along the row and from three pixels of the last.
  for (const int way : {1, -1}) {
    PathRow along(width, depths);
    std::vector<PathRow> last(3, PathRow(width, depths)), now(3, PathRow(width, depths));
    for (int i = 0; i < height; ++i) {
      const int y = way > 0 ? i : height - 1 - i;
      for (int j = 0; j < width; ++j) {
        const int x = way > 0 ? j : width - 1 - j;
        const size_t pixel = static_cast<size_t>(y) * width + x;
        const uint16_t *const cost = costs + pixel * depths;
        uint16_t *const sum = sums.data() + pixel * depths;
        along.least(x) = j == 0 ? begin(cost, depths, along.at(x), sum)
                                : go_on(cost, along.at(x - way), along.least(x - way),
                                        jump_between(grey[pixel], grey[pixel - way]), depths, along.at(x), sum);
        for (int k = 0; k < 3; ++k) {
          const int from = x + (k - 1) * way;  // of the row before
          const size_t other = pixel - static_cast<size_t>(way) * width + from - x;
          now[k].least(x) = i == 0 || from < 0 || from >= width
                                ? begin(cost, depths, now[k].at(x), sum)
                                : go_on(cost, last[k].at(from), last[k].least(from), jump_between(grey[pixel], grey[other]),
                                        depths, now[k].at(x), sum);
        }
      }
      std::swap(last, now);
    }
  }
  for (size_t pixel = 0; pixel < static_cast<size_t>(width) * height; ++pixel) {
    const uint16_t *const sum = sums.data() + pixel * depths;
    const int best = static_cast<int>(std::min_element(sum, sum + depths) - sum);
    float shift = 0.0f;
    if (best > 0 && best < depths - 1) {
      const float left = sum[best - 1], middle = sum[best], right = sum[best + 1];
      const float bend = left - 2.0f * middle + right;
      if (bend > 0.0f) shift = std::min(std::max(0.5f * (left - right) / bend, -0.5f), 0.5f);
    }
    places[pixel] = static_cast<float>(best) + shift;
    matched[pixel] = costs[pixel * depths + best] / kCostUnits;
  }
}

}  // namespace hgs
