// The derivative of compositing, front to back like compositing itself.
//
// A pixel's light is its colour and its depth. With g the gradient of that light, G that of the alpha channel and B the
// background, splat i of light c_i and weight w_i = T_i alpha_i has
//     dL / d alpha_i = T_i g.c_i - (S - w_i g.c_i) / (1 - alpha_i),   S = sum of w_j g.c_j over j >= i + T_end (g.B - G)
// and before the first splat S is known from the picture: g.light - G T_end.
#include <algorithm>

#include "lanes.hpp"
#include "thread_pool.hpp"
#include "tile.hpp"

namespace hgs {
namespace {

constexpr int kPrefetchSlot = 4;  // entries ahead

template <bool depth, bool pulls>
struct TileGradients {
  static constexpr int kChannels = depth ? 4 : 3;  // red, green, blue, depth
  alignas(64) float T[kTilePixels];
  alignas(64) float rest[kTilePixels];  // S above
  alignas(64) float light[kChannels][kTilePixels];

  TileGradients(const Workspace &w, const TilePlace &place, unsigned cells, const hgs_picture &picture,
                const hgs_picture &gradient) {
    place.start_transmittance(T);
    if (place.width < kTile || place.height < kTile) {
      std::fill_n(rest, kTilePixels, 0.0f);
      std::fill_n(light[0], kChannels * kTilePixels, 0.0f);
    }
    const size_t plane = static_cast<size_t>(w.width()) * w.height();
    place.each_vector(w, [&](int i, size_t pixel, int count) {
      const int half = i / (kBlockSize * kCell / kLanes), lower = i / kLanes % kTile / kCell;
      if ((cells >> (half + 2 * lower) & 1) == 0) return;
      Vec sum{};
      const auto add = [&](const float *by, const float *of, float *kept) {
        const Vec g = load_lanes(by + pixel, count);
        store(kept, g);
        sum += g * load_lanes(of + pixel, count);
      };
      for (int c = 0; c < 3; ++c) add(gradient.rgb + c * plane, picture.rgb + c * plane, light[c] + i);
      if constexpr (depth) add(gradient.depth, picture.depth, light[3] + i);
      if (gradient.alpha != nullptr) {
        sum -= load_lanes(gradient.alpha + pixel, count) * (1.0f - load_lanes(picture.alpha + pixel, count));
      }
      store(rest + i, sum);
    });
  }

  // Pass a splat, and write its gradient if it is wanted.
  template <bool wanted>
  void visit(const ScreenSplat &s, const TileEntry &entry, const TilePlace &place, OpenCells open, GradientSlot *slot) {
    const RowTerms rows(s, entry.box, place);
    const Vec colour[] = {broadcast(s.r), broadcast(s.g), broadcast(s.b), broadcast(s.depth)};
    Vec sums[kGradientTerms] = {};
    Vec sum_dy{}, sum_dy2{}, sum_t_dy{};  // of h times these, dy from the middle row
    const float middle_row = static_cast<float>(place.y) + 0.5f * static_cast<float>(entry.box.y0 + entry.box.y1 + 1);
    const float middle_e = s.scale_e * ((middle_row - s.origin_y) - s.mean_y);
    open.each_block(entry.box, [&](int block, int first, int last) {
      const BlockTerms columns(s, entry, block);
      Vec h_0{}, h_dy{}, h_dy2{};
      each_row(rows, columns, first, last, [&](int y, const Opacity &opacity) __attribute__((always_inline)) {
        const int i = block * kBlockSize + y * kLanes;
        const Vec before = load(T + i);
        Vec g[kChannels];
        for (int c = 0; c < kChannels; ++c) g[c] = load(light[c] + i);
        const Blend blend(opacity, before);
        Vec along = g[0] * colour[0] + (g[1] * colour[1] + g[2] * colour[2]);
        if constexpr (depth) along += g[3] * colour[3];
        const Vec share = blend.weight * along, after = load(rest + i) - share;
        store(rest + i, after);
        store(T + i, blend.transmittance);
        if constexpr (wanted) {
          const Mask free = both(blend.drawn, greater_equal(broadcast(kAlphaMax), opacity.unclamped));
          const Vec h = keep(free, share - after * quotient(blend.alpha, 1.0f - blend.alpha)), h_y = h * rows.dy(y);
          h_0 += h;
          h_dy += h_y;
          h_dy2 += h_y * rows.dy(y);
          if constexpr (pulls) {
            const Vec pull = abs(h), t = columns.middle_t + rows.t(y);
            sums[kPullT] += pull * abs(t);
            sums[kPullY] += pull * abs(t * rows.t_by_y + s.scale_e * (middle_e + s.scale_e * rows.dy(y)));
          }
          for (int c = 0; c < 3; ++c) sums[kRed + c] += blend.weight * g[c];
          if constexpr (depth) sums[kDepth] += blend.weight * g[3];
        }
      });
      if constexpr (wanted) {
        // t is linear in dy along a column.
        const Vec t = columns.middle_t, h_t = t * h_0, dy_t = rows.t_by_y * h_dy, h_t_dy = rows.t_by_y * h_dy2;
        sums[kHt] += h_t + dy_t;
        sums[kHtt] += t * (h_t + 2.0f * dy_t) + rows.t_by_y * h_t_dy;
        sum_t_dy += t * h_dy + h_t_dy;
        sum_dy += h_dy;
        sum_dy2 += h_dy2;
        sums[kH] += h_0;
      }
    });
    if constexpr (wanted) {
      sums[kHe] = middle_e * sums[kH] + s.scale_e * sum_dy;
      sums[kHte] = middle_e * sums[kHt] + s.scale_e * sum_t_dy;
      sums[kHee] = middle_e * (sums[kHe] + s.scale_e * sum_dy) + s.scale_e * s.scale_e * sum_dy2;
      static_assert(kGradientTerms == 12);
      sum_each_of_12(sums, slot->terms);
    }
  }
};

// Splats behind the tile's end have no gradient.
void clear_behind(ScreenSet &set, int tile) {
  const uint32_t end = set.tile_begin[tile + 1];
  for (uint32_t e = set.tile_end[tile]; e < end; ++e) set.slots[set.entries[e].slot] = {};
}

// Fetches what the next tile will read, a few rows of pixels at a time between the splats of this one: all at once they
// would wait for each other.
class NextTile {
 public:
  NextTile(const Workspace &w, int tile, const hgs_picture &picture, const hgs_picture &gradient)
      : place_(w, std::min(tile, w.tile_count() - 1)), width_(w.width()) {
    const size_t plane = static_cast<size_t>(w.width()) * w.height(), corner = place_.offset(w, 0) + place_.width - 1;
    for (const hgs_picture *from : {&picture, &gradient}) {
      for (int c = 0; c < 3; ++c) add(from->rgb + c * plane + corner);
      if (gradient.depth != nullptr) add(from->depth + corner);
      if (gradient.alpha != nullptr) add(from->alpha + corner);
    }
  }

  int rows() const { return planes_count_ * place_.height; }

  // Fetch so many rows; it may be more than are left. The left end of a row lies in the cache line of this tile's.
  void fetch(int rows) {
    for (; rows > 0 && plane_ < planes_count_; --rows) {
      const float *const end = planes_[plane_] + static_cast<size_t>(row_) * width_;
      __builtin_prefetch(end - std::min(16, place_.width - 1));
      __builtin_prefetch(end);
      if (++row_ == place_.height) row_ = 0, ++plane_;
    }
  }

 private:
  void add(const float *corner) { planes_[planes_count_++] = corner; }

  TilePlace place_;
  int width_;
  const float *planes_[10];
  int planes_count_ = 0, plane_ = 0, row_ = 0;
};

template <bool depth, bool pulls>
void composite_tile_backward(Workspace &w, int tile, const hgs_picture &picture, const hgs_picture &gradient,
                             GradientSet wanted) {
  if (wanted.statics) clear_behind(w.statics, tile);
  if (wanted.dynamics) clear_behind(w.dynamics, tile);
  TileList list = TileList::drawn(w, tile);
  // Nothing behind the last splat of a wanted set matters.
  const auto done = [&] {
    return (!wanted.statics || list.statics.done()) && (!wanted.dynamics || list.dynamics.done());
  };
  if (done()) return;

  const TilePlace place(w, tile);
  const unsigned cells = w.cells_drawn(tile % w.tiles_x, tile / w.tiles_x);
  TileGradients<depth, pulls> gradients(w, place, cells, picture, gradient);
  OpenCells open(cells);
  NextTile next(w, tile + 1, picture, gradient);
  const int rows_per_splat = next.rows() / std::max(1, list.count()) + 1;
  for (int n = 0; !done(); ++n) {
    if (n % kBatch == 0) open.look(gradients.T);
    const TileList::Item item = list.take();
    next.fetch(rows_per_splat);
    if (item.dynamic ? wanted.dynamics : wanted.statics) {
      const TileRun &run = item.dynamic ? list.dynamics : list.statics;
      GradientSlot *const slots = item.dynamic ? w.dynamics.slots.data() : w.statics.slots.data();
      __builtin_prefetch(&slots[std::min(&item.entry + kPrefetchSlot, run.last)->slot], 1);
      gradients.template visit<true>(item.splat, item.entry, place, open, &slots[item.entry.slot]);
    } else {
      gradients.template visit<false>(item.splat, item.entry, place, open, nullptr);
    }
  }
}

}  // namespace

void composite_backward(Workspace &w, const hgs_picture &picture, const hgs_picture &gradient, GradientSet wanted,
                        bool pulls, int threads) {
  if (wanted.statics) w.statics.slots.reserve(w.entry_count(w.statics));
  if (wanted.dynamics) w.dynamics.slots.reserve(w.entry_count(w.dynamics));
  const bool depth = gradient.depth != nullptr;
  const auto tile_backward = depth ? pulls ? composite_tile_backward<true, true> : composite_tile_backward<true, false>
                             : pulls ? composite_tile_backward<false, true> : composite_tile_backward<false, false>;
  parallel_for(threads, w.tile_count(), 1, [&](int64_t tile) {
    tile_backward(w, static_cast<int>(tile), picture, gradient, wanted);
  });
}

}  // namespace hgs
