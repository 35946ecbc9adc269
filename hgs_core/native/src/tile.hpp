// What the forward and the backward pass over a tile share: the layout of its pixels and the blending of one splat.
#pragma once

#include <algorithm>

#include "simd.hpp"
#include "workspace.hpp"

namespace hgs {

// A tile's pixels are stored in columns of blocks, each one vector wide and 16 rows high, so that a vector is part of
// one row and a splat touches consecutive vectors.
constexpr int kBlocks = kTile / kLanes;
constexpr int kBlockSize = kTile * kLanes;
constexpr int kTilePixels = kTile * kTile;

inline int pixel_index(int x, int y) { return x / kLanes * kBlockSize + y * kLanes + x % kLanes; }

struct TilePlace {
  int x, y;           // corner, pixels
  int width, height;  // at the picture's edge less than 16

  TilePlace(const Workspace &w, int tile)
      : x(tile % w.tiles_x * kTile),
        y(tile / w.tiles_x * kTile),
        width(std::min(kTile, w.camera.width - x)),
        height(std::min(kTile, w.camera.height - y)) {}

  size_t offset(const Workspace &w, int row) const { return static_cast<size_t>(y + row) * w.camera.width + x; }
};

// The part of a splat's exponent that is the same along a row: power = dx (xx dx + linear[row]) + constant[row].
struct RowTerms {
  alignas(64) float dy[kTile], linear[kTile], constant[kTile];

  void set(const ScreenSplat &s, const Vec *row_centres) {
    for (int i = 0; i < kTile / kLanes; ++i) {
      const Vec d = row_centres[i] - s.mean_y;
      store(dy + i * kLanes, d);
      store(linear + i * kLanes, d * s.xy);
      store(constant + i * kLanes, d * d * s.yy + s.log2_opacity);
    }
  }
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
    const Vec attempt = alpha * T;
    drawn = both(visible, greater(T - attempt, broadcast(kTransmittanceMin)));
    weight = keep(drawn, attempt);
    transmittance = set_sign(first_only(visible, drawn), T - weight);
  }
};

}  // namespace hgs
