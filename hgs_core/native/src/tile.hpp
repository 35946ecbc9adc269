// What the passes over a tile share: the layout of its pixels, the order of its splats and the blending of one of them.
#pragma once

#include <algorithm>

#include "simd.hpp"
#include "workspace.hpp"

namespace hgs {

// A tile's pixels are stored in columns of blocks, each one vector wide and 16 rows high, so that a vector is part of
// one row and a splat touches consecutive vectors.
constexpr int kBlockSize = kTile * kLanes;
constexpr int kTilePixels = kTile * kTile;

inline int pixel_index(int x, int y) { return x / kLanes * kBlockSize + y * kLanes + x % kLanes; }

struct TilePlace {
  int x, y;           // corner, pixels
  int width, height;  // at the picture's edge less than 16

  TilePlace(const Workspace &w, int tile)
      : x(tile % w.tiles_x * kTile),
        y(tile / w.tiles_x * kTile),
        width(std::min(kTile, w.width() - x)),
        height(std::min(kTile, w.height() - y)) {}

  size_t offset(const Workspace &w, int row) const { return static_cast<size_t>(y + row) * w.width() + x; }

  // Call f(i, offset, count) for every vector with pixels of the picture: its place in the tile's arrays and in the
  // picture's planes, and how many of its lanes lie within the picture.
  template <class F>
  void each_vector(const Workspace &w, F &&f) const {
    for (int y_row = 0; y_row < height; ++y_row) {
      for (int block = 0; block * kLanes < width; ++block) {
        f(block * kBlockSize + y_row * kLanes, offset(w, y_row) + block * kLanes, std::min(kLanes, width - block * kLanes));
      }
    }
  }

  // Fill T with 1 inside the picture; pixels beyond it are finished from the start.
  void start_transmittance(float *T) const {
    std::fill_n(T, kTilePixels, 1.0f);
    if (width == kTile && height == kTile) return;
    for (int row = 0; row < kTile; ++row) {
      for (int column = 0; column < kTile; ++column) {
        if (column >= width || row >= height) T[pixel_index(column, row)] = -1.0f;
      }
    }
  }
};

// One set's part of a tile's list.
struct TileRun {
  const ScreenSplat *splats;
  const TileEntry *next, *end, *last;  // last: of the whole set, for prefetching beyond the tile

  TileRun(const Workspace &w, const ScreenSet &set, const Buffer<uint32_t> *ends, int tile)
      : splats(set.splats.data()),
        next(set.entries.data() + set.tile_begin[tile]),
        end(set.entries.data() + (ends == nullptr ? set.tile_begin[tile + 1] : (*ends)[tile])),
        last(set.entries.data() + w.entry_count(set) - 1) {}

  bool done() const { return next == end; }
  float depth() const { return splats[next->splat].depth; }
};

// The splats of a tile by depth, statics first where depths are equal.
class TileList {
 public:
  struct Item {
    const TileEntry &entry;
    const ScreenSplat &splat;
    bool dynamic;
  };

  // All of them, or those that the forward pass came to.
  static TileList all(const Workspace &w, int tile) { return {w, nullptr, nullptr, tile}; }
  static TileList drawn(const Workspace &w, int tile) { return {w, &w.statics.tile_end, &w.dynamics.tile_end, tile}; }

  bool done() const { return statics.done() && dynamics.done(); }

  Item take() {
    const bool dynamic = statics.done() || (!dynamics.done() && dynamics.depth() < statics.depth());
    TileRun &run = dynamic ? dynamics : statics;
    __builtin_prefetch(&run.splats[std::min(run.next + kPrefetch, run.last)->splat]);
    const TileEntry &entry = *run.next++;
    return {entry, run.splats[entry.splat], dynamic};
  }

  TileRun statics, dynamics;

 private:
  static constexpr int kPrefetch = 16;  // entries ahead

  TileList(const Workspace &w, const Buffer<uint32_t> *static_ends, const Buffer<uint32_t> *dynamic_ends, int tile)
      : statics(w, w.statics, static_ends, tile), dynamics(w, w.dynamics, dynamic_ends, tile) {}
};

// Pixel centres of a tile: of the first block's columns, and of its rows in vectors.
struct TileCentres {
  Vec columns, rows[kTile / kLanes];

  explicit TileCentres(const TilePlace &place) {
    columns = lane_numbers() + (static_cast<float>(place.x) + 0.5f);
    for (int i = 0; i < kTile / kLanes; ++i) {
      rows[i] = lane_numbers() + (static_cast<float>(place.y + i * kLanes) + 0.5f);
    }
  }
};

// The part of a splat's exponent that is the same along a row, from the first to the last row asked for.
struct RowTerms {
  alignas(64) float dy[kTile], linear[kTile], constant[kTile];

  RowTerms(const ScreenSplat &s, const TileCentres &centres, int first_row, int last_row) {
    for (int i = first_row / kLanes; i <= last_row / kLanes; ++i) {
      const Vec d = centres.rows[i] - s.origin_y - s.mean_y;
      store(dy + i * kLanes, d);
      store(linear + i * kLanes, d * s.root_y);
      store(constant + i * kLanes, s.log2_opacity - d * d * s.fall_y);
    }
  }
};

// A splat in one block of columns.
struct BlockTerms {
  Vec dx, scaled_dx;

  BlockTerms(const ScreenSplat &s, const TileCentres &centres, int block)
      : dx(centres.columns + (static_cast<float>(block * kLanes) - s.origin_x) - s.mean_x), scaled_dx(s.root_x * dx) {}

  // log2 of the alpha of a row's pixels.
  Vec power(const RowTerms &rows, int y) const {
    const Vec t = scaled_dx + rows.linear[y];
    return rows.constant[y] - t * t;
  }
};

// One splat over one vector of pixels. A finished pixel keeps its transmittance with the sign set, so that it costs no
// memory of its own and fails every later test.
struct Blend {
  Mask drawn;
  Vec unclamped_alpha, alpha, weight;  // weight = T alpha where drawn, else 0
  Vec transmittance;                   // after it

  Blend(Vec power, Vec T) {
    const Mask visible = greater_equal(power, broadcast(kLog2AlphaMin));
    unclamped_alpha = exp2(power);
    alpha = min(unclamped_alpha, broadcast(kAlphaMax));
    const Vec attempt = keep(visible, alpha * T), after = T - attempt;
    const Mask unfinished = greater(after, broadcast(kTransmittanceMin));
    drawn = both(visible, unfinished);
    weight = keep(unfinished, attempt);
    transmittance = select(unfinished, after, negative(T));
  }
};

// Draw a splat over the transmittances of a tile; f(i, weight) hears of every vector of pixels.
template <class F>
inline void blend_splat(const ScreenSplat &s, const TileBox &box, const TileCentres &centres, float *T, F &&f) {
  const RowTerms rows(s, centres, box.y0, box.y1);
  for (int block = box.x0 / kLanes; block <= box.x1 / kLanes; ++block) {
    const BlockTerms columns(s, centres, block);
    for (int y = box.y0; y <= box.y1; ++y) {
      const int i = block * kBlockSize + y * kLanes;
      const Blend blend(columns.power(rows, y), load(T + i));
      store(T + i, blend.transmittance);
      f(i, blend.weight);
    }
  }
}

// Whether no pixel of a tile takes any more light.
inline bool finished(const float *T) {
  Vec most = load(T);
  for (int i = kLanes; i < kTilePixels; i += kLanes) most = max(most, load(T + i));
  return !any(greater(most, Vec{}));
}

}  // namespace hgs
