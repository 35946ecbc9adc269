// What the passes over a tile share: the layout of its pixels, the order of its splats and the blending of one of them.
#pragma once

#include <algorithm>

#include "simd.hpp"
#include "workspace.hpp"

namespace hgs {

// A tile's pixels are stored in columns of blocks, each one vector wide and as high as the tile, so that a vector is part of
// one row and a splat touches consecutive vectors.
constexpr int kBlockSize = kTile * kLanes;
constexpr int kTilePixels = kTile * kTile;

constexpr int kBatch = 32;  // splats between two looks at which cells are finished

inline int pixel_index(int x, int y) { return x / kLanes * kBlockSize + y * kLanes + x % kLanes; }

struct TilePlace {
  int x, y;           // corner, pixels
  int width, height;  // at the picture's edge less than a tile's

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

  // Fetch the tile's part of a plane of the picture ahead of its use: the processor does not foresee rows so far apart.
  void prefetch_for_writing(const Workspace &w, const float *plane) const {
    for (int row = 0; row < height; ++row) {
      const float *const last = plane + offset(w, row) + width - 1;
      __builtin_prefetch(last - std::min(16, width - 1), 1);
      __builtin_prefetch(last, 1);
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
  int count() const { return static_cast<int>((statics.end - statics.next) + (dynamics.end - dynamics.next)); }

  Item take() {
    const bool dynamic = statics.done() || (!dynamics.done() && dynamics.depth() < statics.depth());
    TileRun &run = dynamic ? dynamics : statics;
    __builtin_prefetch(&run.splats[std::min(run.next + kPrefetch, run.last)->splat]);
    const TileEntry &entry = *run.next++;
    return {entry, run.splats[entry.splat], dynamic};
  }

  // Remember how far the list was gone through: nothing behind it shows.
  void stop(Workspace &w, int tile) const {
    w.statics.tile_end[tile] = static_cast<uint32_t>(statics.next - w.statics.entries.data());
    w.dynamics.tile_end[tile] = static_cast<uint32_t>(dynamics.next - w.dynamics.entries.data());
  }

  TileRun statics, dynamics;

 private:
  static constexpr int kPrefetch = 16;  // entries ahead

  TileList(const Workspace &w, const Buffer<uint32_t> *static_ends, const Buffer<uint32_t> *dynamic_ends, int tile)
      : statics(w, w.statics, static_ends, tile), dynamics(w, w.dynamics, dynamic_ends, tile) {}
};

// The cells of a tile (Workspace::cells_drawn) in which some pixel takes light yet.
class OpenCells {
 public:
  explicit OpenCells(unsigned drawn) : bits_(drawn) {}

  bool any() const { return bits_ != 0; }

  // Close those where no pixel of T takes any more.
  void look(const float *T) {
    for (int cell = 0; cell < 4; ++cell) {
      if ((bits_ >> cell & 1) != 0 && finished(T, cell)) bits_ &= ~(1u << cell);
    }
  }

  // Call f(block, first row, last row) for every block of columns with pixels of a splat in open cells.
  template <class F>
  void each_block(const TileBox &box, F &&f) const {
    for (int block = box.x0 / kLanes; block <= box.x1 / kLanes; ++block) {
      const int half = block / kHalfBlocks;
      int first = box.half[half].y0, last = box.half[half].y1;
      if ((bits_ >> half & 1) == 0) first = std::max(first, kCell);
      if ((bits_ >> half & 4) == 0) last = std::min(last, kCell - 1);
      if (first <= last) f(block, first, last);
    }
  }

 private:
  static constexpr int kHalfBlocks = kCell / kLanes;

  static bool finished(const float *T, int cell) {
    Vec most = negative(Vec{});
    for (int block = 0; block < kHalfBlocks; ++block) {
      const float *const from = T + (cell % 2 * kHalfBlocks + block) * kBlockSize + cell / 2 * kCell * kLanes;
      for (int row = 0; row < kCell; ++row) most = max(most, load(from + row * kLanes));
    }
    return !hgs::any(greater(most, Vec{}));
  }

  unsigned bits_;
};

// How far the rows or columns of a tile lie from the middle of [first, last], pixels; in vectors.
inline const float *from_middle(int first, int last) {
  struct Table {
    alignas(64) float offsets[2 * kTile - 1][kTile];
    constexpr Table() : offsets{} {
      for (int sum = 0; sum < 2 * kTile - 1; ++sum) {
        for (int i = 0; i < kTile; ++i) offsets[sum][i] = static_cast<float>(i) - 0.5f * static_cast<float>(sum);
      }
    }
  };
  static constexpr Table table;
  return table.offsets[first + last];
}

// The part of a splat's exponent that is the same along a row, for the rows of its box; t from that of the middle row.
struct RowTerms {
  int first;  // row of the box
  float t_by_y;
  const float *from_middle_row;
  alignas(64) float t_of[kTile], constant_of[kTile];

  RowTerms(const ScreenSplat &s, const TileBox &box, const TilePlace &place)
      : first(box.y0), t_by_y(s.scale_t * s.slope), from_middle_row(from_middle(0, box.y1 - box.y0)) {
    const Vec centres = lane_numbers() + (static_cast<float>(place.y + first) + 0.5f);
    for (int i = 0; i <= box.y1 - first; i += kLanes) {
      const Vec e = ((centres + static_cast<float>(i)) - s.origin_y - s.mean_y) * s.scale_e;
      store(t_of + i, load(from_middle_row + i) * t_by_y);
      store(constant_of + i, s.log2_opacity - e * e);
    }
  }

  float t(int y) const { return t_of[y - first]; }
  float constant(int y) const { return constant_of[y - first]; }
  float dy(int y) const { return from_middle_row[y - first]; }  // from the middle row
};

// A splat in one block of columns.
struct BlockTerms {
  Vec middle_t;  // in the middle row

  BlockTerms(const ScreenSplat &s, const TileEntry &entry, int block)
      : middle_t(entry.middle_t + s.scale_t * load(from_middle(entry.box.x0, entry.box.x1) + block * kLanes)) {}

  // log2 of the alpha of a row's pixels.
  Vec power(const RowTerms &rows, int y) const {
    const Vec t = middle_t + rows.t(y);
    return rows.constant(y) - t * t;
  }
};

// Alpha over one vector of pixels before it is known which of them are finished.
struct Opacity {
  Mask visible;
  Vec unclamped;

  explicit Opacity(Vec power) : visible(greater_equal(power, broadcast(kLog2AlphaMin))), unclamped(exp2(power)) {}
};

// Call f(row, opacity) for the rows of a splat in a block. Those of the next row are computed before: the processor would
// otherwise wait for the end of one chain of operations that depend on each other before the next begins.
template <class F>
inline void each_row(const RowTerms &rows, const BlockTerms &columns, int first, int last, F &&f) {
  Opacity next(columns.power(rows, first));
  for (int y = first; y < last; ++y) {
    const Opacity here = next;
    next = Opacity(columns.power(rows, y + 1));
    f(y, here);
  }
  f(last, next);
}

// One splat over one vector of pixels. A finished pixel keeps its transmittance with the sign set, so that it costs no
// memory of its own and fails every later test.
struct Blend {
  Mask drawn;
  Vec alpha, weight;  // weight = T alpha where drawn, else 0
  Vec transmittance;  // after it

  Blend(const Opacity &opacity, Vec T) {
    alpha = min(opacity.unclamped, broadcast(kAlphaMax));
    const Vec attempt = keep(opacity.visible, alpha * T), after = T - attempt;
    const Mask unfinished = greater(after, broadcast(kTransmittanceMin));
    drawn = both(opacity.visible, unfinished);
    weight = keep(unfinished, attempt);
    transmittance = select(unfinished, after, negative(T));
  }
};

// Draw a splat over the transmittances of a tile's open cells; f(i, weight) hears of every vector of pixels.
template <class F>
inline void blend_splat(const ScreenSplat &s, const TileEntry &entry, const TilePlace &place, OpenCells open, float *T,
                        F &&f) {
  const RowTerms rows(s, entry.box, place);
  open.each_block(entry.box, [&](int block, int first, int last) {
    const BlockTerms columns(s, entry, block);
    each_row(rows, columns, first, last, [&](int y, const Opacity &opacity) __attribute__((always_inline)) {
      const int i = block * kBlockSize + y * kLanes;
      const Blend blend(opacity, load(T + i));
      store(T + i, blend.transmittance);
      f(i, blend.weight);
    });
  });
}

}  // namespace hgs
