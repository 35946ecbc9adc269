// The state of one rendering: what projection, binning and compositing hand to each other and to the backward pass.
#pragma once

#include <cstdint>
#include <vector>

#include "buffer.hpp"
#include "hgs_native.h"

namespace hgs {

// docs/numerics.md derives these; hgs_core/render/constants.py has the same ones.
constexpr int kTile = 16;  // pixels
constexpr float kLowPass = 0.3f;  // pixels^2
constexpr float kAlphaMin = 1.0f / 255.0f;
constexpr float kLog2AlphaMin = -7.99435343685886f;
constexpr float kAlphaMax = 0.99f;
constexpr float kTransmittanceMin = 1e-4f;
constexpr float kFrustumMargin = 0.3f;

// An ellipse on the screen, one cache line. Its alpha at the offset (dx, dy) from the mean is 2 to the power of
// log2_opacity + xx dx^2 + xy dx dy + yy dy^2: the conic of docs/numerics.md times -log2(e) / 2.
struct alignas(64) ScreenSplat {
  float mean_x, mean_y;  // pixels
  float xx, xy, yy;
  float log2_opacity;
  float r, g, b;
  float half_x, half_y;  // half-sides of the box outside which alpha < 1/255, pixels
  float determinant;     // of the conic, 1 / pixels^4
  float reach;           // 2 ln(255 opacity): the conic's quadratic form on the edge of the visible ellipse
  float opacity;
  float depth;   // camera-space z
  uint32_t row;  // in its own parameter arrays
};
static_assert(sizeof(ScreenSplat) == 64);

// Pixels of a tile, inclusive, relative to its corner.
struct Box {
  uint8_t x0, x1, y0, y1;
};

// A splat in a tile.
struct TileEntry {
  uint32_t splat;  // in `splats`
  uint32_t slot;   // in `slots`
  Box box;
};

// The same, while it is being sorted into its tile.
struct Emission {
  uint32_t splat;
  uint32_t tile;
  Box box;
};

// What a (splat, tile) pair adds to the gradient of a splat: sums over the tile's pixels of dL / d colour and, with
// h = dL / d ln(alpha) of a pixel and (dx, dy) its offset from the mean, of h times the powers of the offset.
enum GradientTerm { kHdx, kHdy, kHdx2, kHdxdy, kHdy2, kRed, kGreen, kBlue, kH, kGradientTerms };

struct alignas(16) GradientSlot {
  float terms[kGradientTerms];
};

// The emissions of one thread, which has a consecutive part of the splats in order of depth.
struct ThreadEmissions {
  Buffer<Emission> emissions;
  size_t count = 0;
  Buffer<uint32_t> tile_counts;  // [tiles]
};

}  // namespace hgs

struct hgs_workspace {
  hgs_camera camera{};
  float background[3] = {};
  float time = 0;
  int64_t static_count = 0, dynamic_count = 0;
  int tiles_x = 0, tiles_y = 0;

  // Statics occupy [0, static_count) of `splats` and of what is indexed like it, dynamics the rest. Only the places
  // listed in `visible` are in use.
  hgs::Buffer<hgs::ScreenSplat> splats;
  hgs::Buffer<uint32_t> chunk_counts;  // visible splats per chunk of projection
  hgs::Buffer<uint32_t> visible;       // ascending
  int64_t visible_static = 0, visible_count = 0;

  hgs::Buffer<uint32_t> order;                       // `visible` by depth
  hgs::Buffer<uint32_t> keys, other_keys, other_order;  // of the radix sort
  std::vector<hgs::ThreadEmissions> thread_emissions;

  hgs::Buffer<uint32_t> tile_begin;  // [tiles + 1] in `entries`
  hgs::Buffer<uint32_t> tile_end;    // [tiles] where the forward pass found every pixel finished
  hgs::Buffer<hgs::TileEntry> entries;
  hgs::Buffer<uint32_t> first_slot, slot_count;  // per splat: its slots are consecutive
  hgs::Buffer<hgs::GradientSlot> slots;          // [entries]

  int tile_count() const { return tiles_x * tiles_y; }
  int64_t entry_count() const { return tile_begin.data() == nullptr ? 0 : tile_begin[tile_count()]; }
};

namespace hgs {

using Workspace = hgs_workspace;

// The steps of a rendering, in this order.
void project_splats(Workspace &w, const hgs_static_splats &statics, const hgs_dynamic_splats &dynamics, int threads);
hgs_status bin_splats(Workspace &w, const uint8_t *tile_mask, int threads);
void composite(Workspace &w, float *rgb, float *alpha, int threads);

// The steps of its derivative, in this order.
struct GradientSet {
  bool statics, dynamics;
};
void composite_backward(Workspace &w, const float *rgb, const float *alpha, const float *grad_rgb,
                        const float *grad_alpha, GradientSet set, int threads);
void project_splats_backward(const Workspace &w, const hgs_static_splats &statics, const hgs_dynamic_splats &dynamics,
                             const hgs_static_gradients *grad_statics, const hgs_dynamic_gradients *grad_dynamics,
                             const hgs_screen_statistics *statistics, int threads);

}  // namespace hgs
