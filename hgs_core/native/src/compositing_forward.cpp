// Front-to-back compositing of every tile (docs/numerics.md, "Compositing").
#include <algorithm>
#include <cmath>

#include "thread_pool.hpp"
#include "tile.hpp"

namespace hgs {
namespace {

constexpr uint32_t kBatch = 32;     // splats between two looks at whether the tile is finished
constexpr uint32_t kPrefetch = 16;  // splats ahead

struct TilePixels {
  alignas(64) float T[kTilePixels], r[kTilePixels], g[kTilePixels], b[kTilePixels];

  explicit TilePixels(const TilePlace &place) {
    std::fill_n(r, kTilePixels, 0.0f);
    std::fill_n(g, kTilePixels, 0.0f);
    std::fill_n(b, kTilePixels, 0.0f);
    // Pixels beyond the picture are finished from the start.
    for (int y = 0; y < kTile; ++y) {
      for (int x = 0; x < kTile; ++x) T[pixel_index(x, y)] = x < place.width && y < place.height ? 1.0f : -1.0f;
    }
  }

  bool finished() const {
    Vec most = load(T);
    for (int i = kLanes; i < kTilePixels; i += kLanes) most = max(most, load(T + i));
    return !any(greater(most, Vec{}));
  }

  void draw(const ScreenSplat &s, const Box &box, const TileCentres &centres) {
    RowTerms rows;
    rows.set(s, centres.rows);
    const Vec red = broadcast(s.r), green = broadcast(s.g), blue = broadcast(s.b);
    for (int block = box.x0 / kLanes; block <= box.x1 / kLanes; ++block) {
      const Vec dx = centres.columns + (static_cast<float>(block * kLanes) - s.mean_x), xx_dx = s.xx * dx;
      for (int y = box.y0; y <= box.y1; ++y) {
        const int i = block * kBlockSize + y * kLanes;
        const Blend blend(dx * (xx_dx + rows.linear[y]) + rows.constant[y], load(T + i));
        store(T + i, blend.transmittance);
        store(r + i, load(r + i) + blend.weight * red);
        store(g + i, load(g + i) + blend.weight * green);
        store(b + i, load(b + i) + blend.weight * blue);
      }
    }
  }
};

void composite_tile(Workspace &w, int tile, float *rgb, float *alpha) {
  const TilePlace place(w, tile);
  const TileCentres centres(place);
  TilePixels pixels(place);
  const TileEntry *const entries = w.entries.data();
  const uint32_t last = static_cast<uint32_t>(w.entry_count()) - 1;
  uint32_t e = w.tile_begin[tile];
  const uint32_t end = w.tile_begin[tile + 1];
  while (e < end && !pixels.finished()) {
    for (const uint32_t batch_end = std::min(end, e + kBatch); e < batch_end; ++e) {
      __builtin_prefetch(&w.splats[entries[std::min(e + kPrefetch, last)].splat]);
      pixels.draw(w.splats[entries[e].splat], entries[e].box, centres);
    }
  }
  w.tile_end[tile] = e;

  const size_t plane = static_cast<size_t>(w.camera.width) * w.camera.height;
  for (int y = 0; y < place.height; ++y) {
    const size_t row = place.offset(w, y);
    for (int x = 0; x < place.width; ++x) {
      const int i = pixel_index(x, y);
      const float T = std::fabs(pixels.T[i]);
      rgb[row + x] = pixels.r[i] + T * w.background[0];
      rgb[row + x + plane] = pixels.g[i] + T * w.background[1];
      rgb[row + x + 2 * plane] = pixels.b[i] + T * w.background[2];
      alpha[row + x] = 1.0f - T;
    }
  }
}

}  // namespace

void composite(Workspace &w, float *rgb, float *alpha, int threads) {
  parallel_for(threads, w.tile_count(), 4, [&](int64_t tile) {
    composite_tile(w, static_cast<int>(tile), rgb, alpha);
  });
}

}  // namespace hgs
