// The list of every tile.
//
// A splat enters the tiles that its visible ellipse reaches, with the box of pixels it can change there. Lists are made
// without atomics: every thread emits a consecutive part of the splats in order of depth, and a prefix sum over
// (tile, thread) tells where its emissions go, so the lists do not depend on the number of threads.
#include <algorithm>
#include <utility>

#include "depth_sort.hpp"
#include "ellipse.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int64_t kPrefetch = 8;  // splats ahead

// Emits splats into the tiles they reach.
class Emitter {
 public:
  Emitter(const Workspace &w, bool masked, ThreadEmissions &out)
      : w_(w),
        masked_(masked),
        emissions_(out.emissions),
        tile_counts_(out.tile_counts.reserve(w.tile_count())) {
    std::fill_n(tile_counts_, w.tile_count(), 0);
  }

  // Returns into how many tiles.
  uint32_t emit(uint32_t splat, const ScreenSplat &s) {
    const PixelRange box = s.box();
    if (box.empty()) return 0;
    const int tx0 = box.x0 / kTile, tx1 = box.x1 / kTile, ty0 = box.y0 / kTile, ty1 = box.y1 / kTile;
    const size_t before = count_;
    next_ = emissions_.reserve(before + static_cast<size_t>(tx1 - tx0 + 1) * (ty1 - ty0 + 1), before) + before;
    visit(splat, s, ToT(s), box, tx0, ty0, ty1);
    count_ = next_ - emissions_.data();
    return static_cast<uint32_t>(count_ - before);
  }

  size_t count() const { return count_; }

 private:
  // The coordinate t of a place on the screen, in double precision: once per tile, so that within it t takes small steps
  // from a small number.
  struct ToT {
    double mean_x, mean_y, slope, scale;

    explicit ToT(const ScreenSplat &s)
        : mean_x(static_cast<double>(s.origin_x) + s.mean_x),
          mean_y(static_cast<double>(s.origin_y) + s.mean_y),
          slope(static_cast<double>(s.slope) + s.slope_rest),
          scale(s.scale_t) {}

    float operator()(double x, double y) const {
      return static_cast<float>(scale * ((x - mean_x) + slope * (y - mean_y)));
    }
  };

  void visit(uint32_t splat, const ScreenSplat &s, const ToT &to_t, const PixelRange &box, int tx0, int ty0,
             int ty1) {
    const bool one_half = box.x0 / kCell == box.x1 / kCell;  // of one column of tiles
    if (one_half && ty0 == ty1) {
      PixelRange halves[] = {kNoPixels, kNoPixels};
      halves[box.x0 / kCell % 2] = box;
      add(splat, to_t, tx0, ty0, cells_listed(tx0, ty0), halves);
      return;
    }
    const Ellipse ellipse(s);
    for (int ty = ty0; ty <= ty1; ++ty) {
      const int top = std::max(box.y0, ty * kTile), bottom = std::min(box.y1, ty * kTile + kTile - 1);
      PixelRange row{box.x0, box.x1, top, bottom};
      if (ty0 != ty1) row = ellipse.narrow_x(row);
      if (row.empty()) continue;
      for (int tx = row.x0 / kTile; tx <= row.x1 / kTile; ++tx) {
        const unsigned cells = cells_listed(tx, ty);
        if (cells == 0) continue;
        PixelRange halves[2];
        for (int h = 0; h < 2; ++h) {
          const int left = tx * kTile + h * kCell;
          halves[h] = {std::max(row.x0, left), std::min(row.x1, left + kCell - 1), top, bottom};
          if (halves[h].x1 < halves[h].x0) {
            halves[h] = kNoPixels;
          } else if (!one_half) {
            halves[h] = ellipse.narrow_y(halves[h]);
          }
        }
        add(splat, to_t, tx, ty, cells, halves);
      }
    }
  }

  // The cells of a tile that the list is for.
  unsigned cells_listed(int tx, int ty) const { return masked_ ? w_.cells_drawn(tx, ty) : 15; }

  // The pixels of both halves of a tile, as far as they lie in cells that are drawn.
  void add(uint32_t splat, const ToT &to_t, int tx, int ty, unsigned cells, PixelRange *halves) {
    const int corner_x = tx * kTile, corner_y = ty * kTile;
    PixelRange all = kNoPixels;
    TileBox box{};
    for (int h = 0; h < 2; ++h) {
      PixelRange &r = halves[h];
      if ((cells >> h & 1) == 0) r.y0 = std::max(r.y0, corner_y + kCell);
      if ((cells >> h & 4) == 0) r.y1 = std::min(r.y1, corner_y + kCell - 1);
      if (r.empty()) {
        box.half[h] = {1, 0};
        continue;
      }
      box.half[h] = {static_cast<uint8_t>(r.y0 - corner_y), static_cast<uint8_t>(r.y1 - corner_y)};
      all = {std::min(all.x0, r.x0), std::max(all.x1, r.x1), std::min(all.y0, r.y0), std::max(all.y1, r.y1)};
    }
    if (all.empty()) return;
    box.x0 = static_cast<uint8_t>(all.x0 - corner_x);
    box.x1 = static_cast<uint8_t>(all.x1 - corner_x);
    box.y0 = static_cast<uint8_t>(all.y0 - corner_y);
    box.y1 = static_cast<uint8_t>(all.y1 - corner_y);
    const auto tile = static_cast<uint32_t>(ty * w_.tiles_x + tx);
    *next_++ = {splat, tile, box, to_t(0.5 * (all.x0 + all.x1 + 1), 0.5 * (all.y0 + all.y1 + 1))};
    ++tile_counts_[tile];
  }

  static constexpr PixelRange kNoPixels{1 << 20, -1, 1 << 20, -1};

  const Workspace &w_;
  const bool masked_;
  Buffer<Emission> &emissions_;
  uint32_t *const tile_counts_;
  Emission *next_ = nullptr;
  size_t count_ = 0;
};

}  // namespace

void list_by_tile(Workspace &w, ScreenSet &set, int threads) {
  sort_by_depth(set, w.scratch, threads);
  const int tiles = w.tile_count();
  const int64_t visible = set.visible_count;
  set.first_slot.reserve(set.count);
  set.slot_count.reserve(set.count);
  std::vector<ThreadEmissions> &scratch = w.scratch.threads;
  if (scratch.size() < static_cast<size_t>(threads)) scratch.resize(threads);

  // Lists that are kept serve frames with other masks.
  const bool kept = &set == &w.statics && w.view.statics_use == HGS_STATICS_KEEP;
  parallel_ranges(threads, visible, [&](int thread, int64_t begin, int64_t end) {
    Emitter emitter(w, !kept, scratch[thread]);
    for (int64_t i = begin; i < end; ++i) {
      __builtin_prefetch(&set.splats[set.order[std::min(i + kPrefetch, end - 1)]]);
      const uint32_t splat = set.order[i];
      set.slot_count[splat] = emitter.emit(splat, set.splats[splat]);
    }
    scratch[thread].count = emitter.count();
  });

  // Slots in the order in which they will be added up.
  uint32_t slots = 0;
  for (int64_t i = 0; i < visible; ++i) {
    const uint32_t splat = set.visible[i];
    set.first_slot[splat] = slots;
    slots += set.slot_count[splat];
  }

  // Turn the counts into places: tile after tile and, within a tile, thread after thread.
  uint32_t *const tile_begin = set.tile_begin.reserve(tiles + 1);
  set.tile_end.reserve(tiles);
  uint32_t total = 0;
  for (int tile = 0; tile < tiles; ++tile) {
    tile_begin[tile] = total;
    for (int t = 0; t < threads; ++t) total += std::exchange(scratch[t].tile_counts[tile], total);
  }
  tile_begin[tiles] = total;

  TileEntry *const entries = set.entries.reserve(total);
  parallel_ranges(threads, visible, [&](int thread, int64_t, int64_t) {
    ThreadEmissions &mine = scratch[thread];
    uint32_t slot = 0;
    for (size_t i = 0; i < mine.count; ++i) {
      const Emission &e = mine.emissions[i];
      slot = i > 0 && e.splat == mine.emissions[i - 1].splat ? slot + 1 : set.first_slot[e.splat];
      entries[mine.tile_counts[e.tile]++] = {e.splat, slot, e.box, e.middle_t};
    }
  });
}

}  // namespace hgs
