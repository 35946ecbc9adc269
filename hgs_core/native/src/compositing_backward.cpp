// The derivative of compositing, front to back like compositing itself.
//
// With g the gradient of a pixel's colour, G that of its alpha channel and B the background, splat i of weight w_i = T_i
// alpha_i has
//     dL / d alpha_i = T_i g.c_i - (S - w_i g.c_i) / (1 - alpha_i),   S = sum of w_j g.c_j over j >= i + T_end (g.B - G)
// and before the first splat S is known from the picture: g.rgb - G T_end.
#include <algorithm>

#include "thread_pool.hpp"
#include "tile.hpp"

namespace hgs {
namespace {

constexpr uint32_t kPrefetch = 16, kPrefetchSlot = 4;  // entries ahead

struct TileGradients {
  alignas(64) float T[kTilePixels];
  alignas(64) float rest[kTilePixels];  // S above
  alignas(64) float r[kTilePixels], g[kTilePixels], b[kTilePixels];

  TileGradients(const Workspace &w, const TilePlace &place, const float *rgb, const float *alpha,
                const float *grad_rgb, const float *grad_alpha) {
    if (place.width < kTile || place.height < kTile) {
      std::fill_n(T, kTilePixels, -1.0f);
      for (float *plane : {rest, r, g, b}) std::fill_n(plane, kTilePixels, 0.0f);
    }
    const size_t plane = static_cast<size_t>(w.camera.width) * w.camera.height;
    for (int y = 0; y < place.height; ++y) {
      const size_t row = place.offset(w, y);
      for (int x = 0; x < place.width; ++x) {
        const int i = pixel_index(x, y);
        const size_t red = row + x, green = red + plane, blue = green + plane;
        T[i] = 1.0f;
        r[i] = grad_rgb[red];
        g[i] = grad_rgb[green];
        b[i] = grad_rgb[blue];
        rest[i] = r[i] * rgb[red] + g[i] * rgb[green] + b[i] * rgb[blue];
        if (grad_alpha != nullptr) rest[i] -= grad_alpha[red] * (1.0f - alpha[red]);
      }
    }
  }

  // Pass a splat whose own gradient nobody wants.
  void pass(const ScreenSplat &s, const Box &box, const TileCentres &centres) { visit<false>(s, box, centres, nullptr); }

  // Pass a splat and write its gradient.
  void differentiate(const ScreenSplat &s, const Box &box, const TileCentres &centres, GradientSlot *slot) {
    visit<true>(s, box, centres, slot);
  }

 private:
  template <bool wanted>
  void visit(const ScreenSplat &s, const Box &box, const TileCentres &centres, GradientSlot *slot) {
    RowTerms rows;
    rows.set(s, centres.rows);
    const Vec red = broadcast(s.r), green = broadcast(s.g), blue = broadcast(s.b);
    Vec sums[kGradientTerms] = {};
    for (int block = box.x0 / kLanes; block <= box.x1 / kLanes; ++block) {
      const Vec dx = centres.columns + (static_cast<float>(block * kLanes) - s.mean_x), xx_dx = s.xx * dx;
      Vec h_0{}, h_dy{}, h_dy2{};
      for (int y = box.y0; y <= box.y1; ++y) {
        const int i = block * kBlockSize + y * kLanes;
        const Vec before = load(T + i), gr = load(r + i), gg = load(g + i), gb = load(b + i);
        const Blend blend(dx * (xx_dx + rows.linear[y]) + rows.constant[y], before);
        const Vec along = gr * red + (gg * green + gb * blue);
        const Vec after = load(rest + i) - blend.weight * along;
        store(rest + i, after);
        store(T + i, blend.transmittance);
        if constexpr (wanted) {
          const Vec d_alpha = before * along - after * reciprocal(1.0f - blend.alpha);
          const Mask free = both(blend.drawn, greater_equal(broadcast(kAlphaMax), blend.unclamped_alpha));
          const Vec h = keep(free, d_alpha * blend.unclamped_alpha), h_y = h * rows.dy[y];
          h_0 += h;
          h_dy += h_y;
          h_dy2 += h_y * rows.dy[y];
          sums[kRed] += blend.weight * gr;
          sums[kGreen] += blend.weight * gg;
          sums[kBlue] += blend.weight * gb;
        }
      }
      if constexpr (wanted) {
        const Vec h_dx = h_0 * dx;
        sums[kHdx] += h_dx;
        sums[kHdy] += h_dy;
        sums[kHdx2] += h_dx * dx;
        sums[kHdxdy] += h_dy * dx;
        sums[kHdy2] += h_dy2;
        sums[kH] += h_0;
      }
    }
    if constexpr (wanted) {
      static_assert(kGradientTerms == 9);
      sum_each_of_8(sums, slot->terms);
      slot->terms[8] = sum(sums[8]);
    }
  }
};

void composite_tile_backward(Workspace &w, int tile, const float *rgb, const float *alpha, const float *grad_rgb,
                             const float *grad_alpha, GradientSet set) {
  const TileEntry *const entries = w.entries.data();
  const uint32_t begin = w.tile_begin[tile], drawn_end = w.tile_end[tile], end = w.tile_begin[tile + 1];
  const auto in_set = [&](const TileEntry &entry) { return entry.splat < w.static_count ? set.statics : set.dynamics; };
  // Nothing behind the last splat of the set matters; splats behind the tile's end have no gradient.
  uint32_t needed_end = drawn_end;
  while (needed_end > begin && !in_set(entries[needed_end - 1])) --needed_end;
  for (uint32_t e = drawn_end; e < end; ++e) w.slots[entries[e].slot] = {};
  if (needed_end == begin) return;

  const TilePlace place(w, tile);
  const TileCentres centres(place);
  TileGradients gradients(w, place, rgb, alpha, grad_rgb, grad_alpha);
  const uint32_t last = static_cast<uint32_t>(w.entry_count()) - 1;
  for (uint32_t e = begin; e < needed_end; ++e) {
    __builtin_prefetch(&w.splats[entries[std::min(e + kPrefetch, last)].splat]);
    __builtin_prefetch(&w.slots[entries[std::min(e + kPrefetchSlot, last)].slot], 1);
    const TileEntry &entry = entries[e];
    const ScreenSplat &s = w.splats[entry.splat];
    if (in_set(entry)) {
      gradients.differentiate(s, entry.box, centres, &w.slots[entry.slot]);
    } else {
      gradients.pass(s, entry.box, centres);
    }
  }
}

}  // namespace

void composite_backward(Workspace &w, const float *rgb, const float *alpha, const float *grad_rgb,
                        const float *grad_alpha, GradientSet set, int threads) {
  w.slots.reserve(w.entry_count());
  parallel_for(threads, w.tile_count(), 4, [&](int64_t tile) {
    composite_tile_backward(w, static_cast<int>(tile), rgb, alpha, grad_rgb, grad_alpha, set);
  });
}

}  // namespace hgs
