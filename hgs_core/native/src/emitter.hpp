// Which tiles the visible ellipse of a splat reaches, with the box of pixels that it can change there.
#pragma once

#include <algorithm>
#include <cstring>

#include "ellipse.hpp"
#include "wide.hpp"
#include "workspace.hpp"

namespace hgs {

// Emits splats into the tiles they reach: lists pairs of a splat and a tile of its box, a batch at a time, and then finds
// the pixels of a vector of them at once.
class Emitter {
 public:
  // Tiles are masked if only what lies in cells that are drawn is listed. `slot_count` [splats] hears into how many tiles
  // each splat was emitted.
  Emitter(const Workspace &w, const ScreenSet &set, bool masked, uint32_t *slot_count, ThreadEmissions &out)
      : w_(w),
        splats_(set.splats.data()),
        masked_(masked),
        slot_count_(slot_count),
        emissions_(out.emissions),
        tile_counts_(out.tile_counts.reserve(w.tile_count())) {
    std::fill_n(tile_counts_, w.tile_count(), 0);
  }

  void emit(uint32_t splat) {
    const ScreenSplat &s = splats_[splat];
    slot_count_[splat] = 0;
    const bool empty = s.x1 < s.x0 || s.y1 < s.y0;
    const int tx0 = s.x0 / kTile, tx1 = s.x1 / kTile, ty0 = s.y0 / kTile, ty1 = s.y1 / kTile;
    if (!masked_ && static_cast<unsigned>(tx1 - tx0) <= 1 && static_cast<unsigned>(ty1 - ty0) <= 1) {
      // Nearly all of them; without branches, which would be hard to foresee.
      put(waiting_, splat, tx0, ty0);
      put(waiting_ + 1, splat, tx1, ty0);
      const int in_a_row = empty ? 0 : tx1 - tx0 + 1;
      waiting_ += in_a_row;
      put(waiting_, splat, tx0, ty1);
      put(waiting_ + 1, splat, tx1, ty1);
      waiting_ += ty0 == ty1 ? 0 : in_a_row;
      if (waiting_ >= kBatch) find_pixels(kBatch);
    } else if (!empty) {
      emit_all(splat, s, tx0, tx1, ty0, ty1);
    }
  }

  // Emit what still waits, and return how many emissions there are.
  size_t finish() {
    find_pixels(waiting_);
    return count_;
  }

 private:
  static constexpr int kWide = 4;    // tiles: most of the box of a slanting splat that is wider may be empty
  static constexpr int kBatch = 64;  // candidates
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);  // pairs and boxes of small numbers are read as one number

  // A tile that a splat's box reaches.
  struct Candidate {
    uint32_t splat;
    uint16_t tile_x, tile_y;
  };

  // Of a vector of candidates.
  struct Lanes {
    Vec origin_x, origin_y, mean_x, mean_y, slope, slope_rest, scale_t, scale_e, log2_opacity;
    Vec x0, x1, y0, y1;      // the box, pixels
    Vec corner_x, corner_y;  // of the tile, pixels

    Lanes(const ScreenSplat *splats, const Candidate *candidates, int count) {
      alignas(64) float fields[9][kLanes];
      alignas(64) uint32_t box_x[kLanes], box_y[kLanes], tile[kLanes];
      for (int k = 0; k < kLanes; ++k) {
        const Candidate &c = candidates[std::min(k, count - 1)];
        const ScreenSplat &s = splats[c.splat];
        fields[0][k] = s.origin_x, fields[1][k] = s.origin_y, fields[2][k] = s.mean_x, fields[3][k] = s.mean_y;
        fields[4][k] = s.slope, fields[5][k] = s.slope_rest, fields[6][k] = s.scale_t, fields[7][k] = s.scale_e;
        fields[8][k] = s.log2_opacity;
        std::memcpy(&box_x[k], &s.x0, 4);
        std::memcpy(&box_y[k], &s.y0, 4);
        std::memcpy(&tile[k], &c.tile_x, 4);
      }
      origin_x = load(fields[0]), origin_y = load(fields[1]), mean_x = load(fields[2]), mean_y = load(fields[3]);
      slope = load(fields[4]), slope_rest = load(fields[5]), scale_t = load(fields[6]), scale_e = load(fields[7]);
      log2_opacity = load(fields[8]);
      const auto low = [](const uint32_t *pairs) { return as_floats(load_bits(pairs) & 0xffffu); };
      const auto high = [](const uint32_t *pairs) { return as_floats(load_bits(pairs) >> 16); };
      x0 = low(box_x), x1 = high(box_x), y0 = low(box_y), y1 = high(box_y);
      corner_x = kTile * low(tile), corner_y = kTile * high(tile);
    }
  };

  // The tiles of a row that the ellipse may reach.
  static void narrow_row(const ScreenSplat &s, int ty, int &from, int &to) {
    const int top = std::max<int>(s.y0, ty * kTile), bottom = std::min<int>(s.y1, ty * kTile + kTile - 1);
    const auto row = Ellipse<float>(s).narrow_x({static_cast<float>(s.x0), static_cast<float>(s.x1),
                                                 static_cast<float>(top), static_cast<float>(bottom)});
    from = static_cast<int>(row.x0) / kTile;
    to = row.x1 < row.x0 ? from - 1 : static_cast<int>(row.x1) / kTile;
  }

  void emit_all(uint32_t splat, const ScreenSplat &s, int tx0, int tx1, int ty0, int ty1) {
    for (int ty = ty0; ty <= ty1; ++ty) {
      int from = tx0, to = tx1;
      if (tx1 - tx0 > kWide && ty0 != ty1) narrow_row(s, ty, from, to);
      for (int tx = from; tx <= to; ++tx) {
        if (masked_ && w_.cells_drawn(tx, ty) == 0) continue;
        put(waiting_++, splat, tx, ty);
        if (waiting_ == kBatch) find_pixels(kBatch);
      }
    }
  }

  void put(int place, uint32_t splat, int tx, int ty) {
    candidates_[place] = {splat, static_cast<uint16_t>(tx), static_cast<uint16_t>(ty)};
  }

  // The coordinate t of a place on the screen, in double precision: once per tile, so that within it t takes small steps
  // from a small number.
  static Vec to_t(const Lanes &s, Vec x, Vec y) {
    const Wide dx = widen(x) - (widen(s.origin_x) + widen(s.mean_x));
    const Wide dy = widen(y) - (widen(s.origin_y) + widen(s.mean_y));
    return narrow(widen(s.scale_t) * (dx + (widen(s.slope) + widen(s.slope_rest)) * dy));
  }

  // Emit the first candidates that wait.
  void find_pixels(int count) {
    for (int k = 0; k < count; k += kLanes) find_pixels(candidates_ + k, std::min(kLanes, count - k));
    waiting_ -= count;
    std::copy_n(candidates_ + count, waiting_, candidates_);
  }

  // Emit candidates as far as the ellipse reaches pixels of theirs in cells that are drawn.
  void find_pixels(const Candidate *candidates, int count) {
    const Lanes s(splats_, candidates, count);
    const Ellipse<Vec> ellipse(s);
    const Vec top = max(s.y0, s.corner_y), bottom = min(s.y1, s.corner_y + (kTile - 1.0f));
    using Range = typename Ellipse<Vec>::Range;
    Range row{s.x0, s.x1, top, bottom};
    const Mask one_row = both(greater_equal(s.y0, top), greater_equal(bottom, s.y1));
    const Range narrowed = ellipse.narrow_x(row);
    row.x0 = select(one_row, row.x0, narrowed.x0);
    row.x1 = select(one_row, row.x1, narrowed.x1);

    const VecBits cells = cells_of(candidates, count);
    const auto bit = [&](int n) { return as_floats(cells >> n & 1u); };
    Range all{broadcast(kNone), broadcast(-1.0f), broadcast(kNone), broadcast(-1.0f)};
    VecBits halves{};
    for (int h = 0; h < 2; ++h) {
      const Vec left = s.corner_x + static_cast<float>(h * kCell);
      Range r{max(row.x0, left), min(row.x1, left + (kCell - 1.0f)), top, bottom};
      const Mask some = greater_equal(r.x1, r.x0);
      const Mask whole = both(one_row, both(greater_equal(s.x0, left), greater_equal(left + (kCell - 1.0f), s.x1)));
      const Range within = ellipse.narrow_y(r);
      r.y0 = max(select(whole, r.y0, within.y0), s.corner_y + kCell * (1.0f - bit(h)));
      r.y1 = min(select(whole, r.y1, within.y1), s.corner_y + (kCell - 1.0f) + kCell * bit(h + 2));
      const Mask reached = both(some, greater_equal(r.y1, r.y0));
      all.x0 = min(all.x0, select(reached, r.x0, all.x0));
      all.x1 = max(all.x1, select(reached, r.x1, all.x1));
      all.y0 = min(all.y0, select(reached, r.y0, all.y0));
      all.y1 = max(all.y1, select(reached, r.y1, all.y1));
      const Vec first = select(reached, r.y0 - s.corner_y, broadcast(1.0f));
      halves |= (whole_number(first) | whole_number(keep(reached, r.y1 - s.corner_y)) << 8) << (16 * h);
    }
    uint32_t reached = lane_bits(greater_equal(all.x1, all.x0)) & ((2u << (count - 1)) - 1);
    alignas(64) uint32_t corners[kLanes], rows_of_halves[kLanes];
    alignas(64) float middle_t[kLanes];
    const VecBits columns = whole_number(all.x0 - s.corner_x) | whole_number(all.x1 - s.corner_x) << 8;
    store_bits(corners, columns | (whole_number(all.y0 - s.corner_y) | whole_number(all.y1 - s.corner_y) << 8) << 16);
    store_bits(rows_of_halves, halves);
    store(middle_t, to_t(s, 0.5f * (all.x0 + all.x1 + 1.0f), 0.5f * (all.y0 + all.y1 + 1.0f)));

    Emission *const out = emissions_.reserve(count_ + kLanes, count_);
    for (; reached != 0; reached &= reached - 1) {
      const int k = __builtin_ctz(reached);
      TileBox box;
      std::memcpy(&box, &corners[k], 4);
      std::memcpy(&box.half, &rows_of_halves[k], 4);
      const Candidate &c = candidates[k];
      const auto tile = static_cast<uint32_t>(c.tile_y * w_.tiles_x + c.tile_x);
      out[count_++] = {c.splat, tile, box, middle_t[k]};
      ++tile_counts_[tile];
      ++slot_count_[c.splat];
    }
  }

  // The cells of their tiles that are to be listed.
  VecBits cells_of(const Candidate *candidates, int count) const {
    VecBits cells = VecBits{} + 15u;
    if (!masked_) return cells;
    for (int k = 0; k < count; ++k) cells[k] = w_.cells_drawn(candidates[k].tile_x, candidates[k].tile_y);
    return cells;
  }

  static VecBits whole_number(Vec x) { return (VecBits)__builtin_convertvector(x, VecInt); }
  static Vec as_floats(VecBits whole_numbers) { return __builtin_convertvector((VecInt)whole_numbers, Vec); }
  static VecBits load_bits(const uint32_t *from) { return *reinterpret_cast<const VecBits *>(from); }
  static void store_bits(uint32_t *to, VecBits bits) { *reinterpret_cast<VecBits *>(to) = bits; }

  static constexpr float kNone = 1 << 20;  // pixels; beyond every picture

  const Workspace &w_;
  const ScreenSplat *const splats_;
  const bool masked_;
  uint32_t *const slot_count_;
  Buffer<Emission> &emissions_;
  uint32_t *const tile_counts_;
  size_t count_ = 0;

  int waiting_ = 0;
  Candidate candidates_[kBatch + 4];
};

}  // namespace hgs
