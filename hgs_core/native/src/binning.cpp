// Sorting by depth, and the list of every tile.
//
// A splat enters the tiles that its visible ellipse reaches, with the box of pixels it can change there. Lists are made
// without atomics: every thread emits a consecutive part of the splats in order of depth, and a prefix sum over
// (tile, thread) tells where its emissions go, so the lists do not depend on the number of threads.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "thread_pool.hpp"
#include "workspace.hpp"

namespace hgs {
namespace {

// Pixels; covers the rounding of the edges. A pixel inside the box but outside the ellipse costs time only.
constexpr float kSlack = 1e-3f;

// Fill w.order: radix sort of the visible splats by depth; stable, so equal depths stay in order of index.
void sort_by_depth(Workspace &w) {
  const size_t n = w.visible_count;
  uint32_t *keys = w.keys.reserve(n), *other_keys = w.other_keys.reserve(n);
  uint32_t *order = w.order.reserve(n), *other_order = w.other_order.reserve(n);
  constexpr int kDigitBits = 11, kDigits = 1 << kDigitBits;
  static thread_local std::array<std::array<uint32_t, kDigits>, 3> counts;
  for (auto &c : counts) c.fill(0);

  // Depths are positive, so their bits sort as they do.
  for (size_t i = 0; i < n; ++i) {
    uint32_t key;
    std::memcpy(&key, &w.splats[w.visible[i]].depth, sizeof key);
    other_keys[i] = key;
    for (int pass = 0; pass < 3; ++pass) ++counts[pass][key >> (pass * kDigitBits) & (kDigits - 1)];
  }
  const uint32_t *from_order = w.visible.data(), *from_keys = other_keys;
  uint32_t *to_order = order, *to_keys = keys;
  for (int pass = 0; pass < 3; ++pass) {
    uint32_t place = 0;
    for (uint32_t &count : counts[pass]) place += std::exchange(count, place);
    for (size_t i = 0; i < n; ++i) {
      const uint32_t to = counts[pass][from_keys[i] >> (pass * kDigitBits) & (kDigits - 1)]++;
      to_keys[to] = from_keys[i];
      to_order[to] = from_order[i];
    }
    from_order = to_order;
    from_keys = to_keys;
    to_order = to_order == order ? other_order : order;
    to_keys = to_keys == keys ? other_keys : keys;
  }
}

// Pixels, inclusive; empty when x1 < x0 or y1 < y0.
struct PixelRange {
  int x0, x1, y0, y1;
  bool empty() const { return x1 < x0 || y1 < y0; }
};

// The first and the last pixel whose centre lies in [low, high], within [first, last].
int first_centre(float low, int first, int last) {
  return static_cast<int>(std::ceil(std::clamp(low - 0.5f - kSlack, static_cast<float>(first), last + 1.0f)));
}
int last_centre(float high, int first, int last) {
  return static_cast<int>(std::floor(std::clamp(high - 0.5f + kSlack, first - 1.0f, static_cast<float>(last))));
}

PixelRange bounding_box(const ScreenSplat &s, int width, int height) {
  return {first_centre(s.mean_x - s.half_x, 0, width - 1), last_centre(s.mean_x + s.half_x, 0, width - 1),
          first_centre(s.mean_y - s.half_y, 0, height - 1), last_centre(s.mean_y + s.half_y, 0, height - 1)};
}

int64_t tiles_of(const PixelRange &r) {
  if (r.empty()) return 0;
  return static_cast<int64_t>(r.x1 / kTile - r.x0 / kTile + 1) * (r.y1 / kTile - r.y0 / kTile + 1);
}

// The visible ellipse a dx^2 + 2 b dx dy + c dy^2 <= reach about the mean.
class Ellipse {
 public:
  explicit Ellipse(const ScreenSplat &s) : mean_x_(s.mean_x), mean_y_(s.mean_y), det_(s.determinant) {
    constexpr float kUnscale = -2.0f * 0.693147180559945309f;  // undoes the -log2(e) / 2 of ScreenSplat
    const float a = kUnscale * s.xx, b = 0.5f * kUnscale * s.xy, c = kUnscale * s.yy;
    slope_x_ = -b / a;
    slope_y_ = -b / c;
    inverse_a_ = 1.0f / a;
    inverse_c_ = 1.0f / c;
    a_reach_ = a * s.reach;
    c_reach_ = c * s.reach;
    dy_of_right_ = slope_y_ * s.half_x;
    dx_of_bottom_ = slope_x_ * s.half_y;
  }

  // The pixels of `r` narrowed in x to what the ellipse covers of its rows.
  PixelRange narrow_x(PixelRange r) const {
    const float top = r.y0 + 0.5f - mean_y_, bottom = r.y1 + 0.5f - mean_y_;
    const float right = std::clamp(dy_of_right_, top, bottom), left = std::clamp(-dy_of_right_, top, bottom);
    const float x1 = mean_x_ + slope_x_ * right + half_chord_x(right);
    const float x0 = mean_x_ + slope_x_ * left - half_chord_x(left);
    return {first_centre(x0, r.x0, r.x1), last_centre(x1, r.x0, r.x1), r.y0, r.y1};
  }

  // The same in y for its columns.
  PixelRange narrow_y(PixelRange r) const {
    const float left = r.x0 + 0.5f - mean_x_, right = r.x1 + 0.5f - mean_x_;
    const float bottom = std::clamp(dx_of_bottom_, left, right), top = std::clamp(-dx_of_bottom_, left, right);
    const float y1 = mean_y_ + slope_y_ * bottom + half_chord_y(bottom);
    const float y0 = mean_y_ + slope_y_ * top - half_chord_y(top);
    return {r.x0, r.x1, first_centre(y0, r.y0, r.y1), last_centre(y1, r.y0, r.y1)};
  }

 private:
  float half_chord_x(float dy) const { return std::sqrt(std::max(0.0f, a_reach_ - det_ * dy * dy)) * inverse_a_; }
  float half_chord_y(float dx) const { return std::sqrt(std::max(0.0f, c_reach_ - det_ * dx * dx)) * inverse_c_; }

  float mean_x_, mean_y_, det_;
  float slope_x_, slope_y_;  // the chords' middles lie at dx = slope_x dy and dy = slope_y dx
  float inverse_a_, inverse_c_, a_reach_, c_reach_;
  float dy_of_right_, dx_of_bottom_;  // where the ellipse's extreme points lie
};

// Emit one splat into the tiles it reaches.
class Emitter {
 public:
  Emitter(const Workspace &w, const uint8_t *tile_mask, Emission *out, uint32_t *tile_counts)
      : w_(w), tile_mask_(tile_mask), next_(out), tile_counts_(tile_counts) {}

  void emit(uint32_t splat) {
    const ScreenSplat &s = w_.splats[splat];
    const PixelRange box = bounding_box(s, w_.camera.width, w_.camera.height);
    const int64_t tiles = tiles_of(box);
    if (tiles == 0) return;
    if (tiles == 1) {
      add(splat, box.x0 / kTile, box.y0 / kTile, box);
      return;
    }
    const Ellipse ellipse(s);
    for (int ty = box.y0 / kTile; ty <= box.y1 / kTile; ++ty) {
      const PixelRange row = ellipse.narrow_x(
          {box.x0, box.x1, std::max(box.y0, ty * kTile), std::min(box.y1, ty * kTile + kTile - 1)});
      if (row.empty()) continue;
      for (int tx = row.x0 / kTile; tx <= row.x1 / kTile; ++tx) {
        const PixelRange part = ellipse.narrow_y(
            {std::max(row.x0, tx * kTile), std::min(row.x1, tx * kTile + kTile - 1), row.y0, row.y1});
        if (!part.empty()) add(splat, tx, ty, part);
      }
    }
  }

  Emission *end() const { return next_; }

 private:
  void add(uint32_t splat, int tx, int ty, const PixelRange &r) {
    const auto tile = static_cast<uint32_t>(ty * w_.tiles_x + tx);
    if (tile_mask_ != nullptr && tile_mask_[tile] == 0) return;
    const auto x = [&](int i) { return static_cast<uint8_t>(i - tx * kTile); };
    const auto y = [&](int i) { return static_cast<uint8_t>(i - ty * kTile); };
    *next_++ = {splat, tile, {x(r.x0), x(r.x1), y(r.y0), y(r.y1)}};
    ++tile_counts_[tile];
  }

  const Workspace &w_;
  const uint8_t *tile_mask_;
  Emission *next_;
  uint32_t *tile_counts_;
};

}  // namespace

hgs_status bin_splats(Workspace &w, const uint8_t *tile_mask, int threads) {
  sort_by_depth(w);
  const int tiles = w.tile_count();
  const int64_t visible = w.visible_count, splats = w.static_count + w.dynamic_count;
  w.first_slot.reserve(splats);
  w.slot_count.reserve(splats);
  w.thread_emissions.resize(std::max<size_t>(w.thread_emissions.size(), threads));

  // Boxes bound the number of entries from above, before anything is allocated for them.
  std::atomic<int64_t> bound{0};
  parallel_ranges(threads, visible, [&](int thread, int64_t begin, int64_t end) {
    int64_t total = 0;
    for (int64_t i = begin; i < end; ++i) {
      total += tiles_of(bounding_box(w.splats[w.order[i]], w.camera.width, w.camera.height));
    }
    w.thread_emissions[thread].count = total;
    bound += total;
  });
  if (bound > std::numeric_limits<int32_t>::max()) return HGS_TOO_MANY_TILE_ENTRIES;

  parallel_ranges(threads, visible, [&](int thread, int64_t begin, int64_t end) {
    ThreadEmissions &mine = w.thread_emissions[thread];
    Emission *const first = mine.emissions.reserve(mine.count);
    uint32_t *const tile_counts = mine.tile_counts.reserve(tiles);
    std::fill_n(tile_counts, tiles, 0);
    Emitter emitter(w, tile_mask, first, tile_counts);
    for (int64_t i = begin; i < end; ++i) {
      __builtin_prefetch(&w.splats[w.order[std::min(i + 8, end - 1)]]);
      const uint32_t splat = w.order[i];
      const Emission *const before = emitter.end();
      emitter.emit(splat);
      w.first_slot[splat] = static_cast<uint32_t>(before - first);
      w.slot_count[splat] = static_cast<uint32_t>(emitter.end() - before);
    }
    mine.count = emitter.end() - first;
  });

  // Turn the counts into places: tile after tile and, within a tile, thread after thread.
  uint32_t *const tile_begin = w.tile_begin.reserve(tiles + 1);
  w.tile_end.reserve(tiles);
  uint32_t total = 0;
  for (int tile = 0; tile < tiles; ++tile) {
    tile_begin[tile] = total;
    for (int t = 0; t < threads; ++t) total += std::exchange(w.thread_emissions[t].tile_counts[tile], total);
  }
  tile_begin[tiles] = total;

  TileEntry *const entries = w.entries.reserve(total);
  parallel_ranges(threads, visible, [&](int thread, int64_t begin, int64_t end) {
    ThreadEmissions &mine = w.thread_emissions[thread];
    uint32_t slot = 0;
    for (int t = 0; t < thread; ++t) slot += static_cast<uint32_t>(w.thread_emissions[t].count);
    for (int64_t i = begin; i < end; ++i) w.first_slot[w.order[i]] += slot;
    for (size_t i = 0; i < mine.count; ++i) {
      const Emission &e = mine.emissions[i];
      entries[mine.tile_counts[e.tile]++] = {e.splat, slot++, e.box};
    }
  });
  return HGS_OK;
}

}  // namespace hgs
