// Front-to-back compositing of every tile (docs/numerics.md, "Compositing").
#include <algorithm>

#include "thread_pool.hpp"
#include "tile.hpp"

namespace hgs {
namespace {

template <bool depth>
struct TilePixels {
  static constexpr int kChannels = depth ? 4 : 3;  // red, green, blue, depth
  alignas(64) float T[kTilePixels], sums[kChannels][kTilePixels];

  explicit TilePixels(const TilePlace &place) {
    place.start_transmittance(T);
    for (int i = 0; i < kChannels * kTilePixels; i += kLanes) store(sums[0] + i, Vec{});
  }

  void draw(const ScreenSplat &s, const TileEntry &entry, const TilePlace &place, OpenCells open) {
    const Vec colour[] = {broadcast(s.r), broadcast(s.g), broadcast(s.b), broadcast(s.depth)};
    blend_splat(s, entry, place, open, T, [&](int i, Vec weight) {
      for (int c = 0; c < kChannels; ++c) store(sums[c] + i, load(sums[c] + i) + weight * colour[c]);
    });
  }
};

template <bool depth>
void composite_tile(Workspace &w, int tile, const hgs_picture &out) {
  const TilePlace place(w, tile);
  TilePixels<depth> pixels(place);
  const size_t plane = static_cast<size_t>(w.width()) * w.height();
  for (int c = 0; c < 3; ++c) place.prefetch_for_writing(w, out.rgb + c * plane);
  place.prefetch_for_writing(w, out.alpha);
  if constexpr (depth) place.prefetch_for_writing(w, out.depth);
  TileList list = TileList::all(w, tile);
  OpenCells open(w.cells_drawn(tile % w.tiles_x, tile / w.tiles_x));
  for (open.look(pixels.T); !list.done() && open.any(); open.look(pixels.T)) {
    for (int n = 0; n < kBatch && !list.done(); ++n) {
      const TileList::Item item = list.take();
      pixels.draw(item.splat, item.entry, place, open);
    }
  }
  list.stop(w, tile);

  place.each_vector(w, [&](int i, size_t pixel, int count) {
    const Vec T = abs(load(pixels.T + i));
    for (int c = 0; c < 3; ++c) {
      store_lanes(out.rgb + pixel + c * plane, load(pixels.sums[c] + i) + T * w.view.background[c], count);
    }
    store_lanes(out.alpha + pixel, 1.0f - T, count);
    if constexpr (depth) store_lanes(out.depth + pixel, load(pixels.sums[3] + i), count);
  });
}

}  // namespace

void composite(Workspace &w, const hgs_picture &picture, int threads) {
  parallel_for(threads, w.tile_count(), 1, [&](int64_t tile) {
    if (w.depth) {
      composite_tile<true>(w, static_cast<int>(tile), picture);
    } else {
      composite_tile<false>(w, static_cast<int>(tile), picture);
    }
  });
}

}  // namespace hgs
