// What projection, binning and compositing hand to each other, and the constants they share.
#pragma once

#include <cstdint>

#include "buffer.hpp"
#include "hgs_native.h"

namespace hgs {

// docs/numerics.md derives these; hgs_core/render/constants.py has the same ones.
constexpr int kCell = 16;         // pixels; what a tile mask speaks of
constexpr int kTile = 2 * kCell;  // pixels; what splats are listed by: fewer lists, each splat in fewer of them
constexpr float kLowPass = 0.3f;  // pixels^2
constexpr float kAlphaMin = 1.0f / 255.0f;
constexpr float kLog2AlphaMin = -7.99435343685886f;
constexpr float kExponentScale = 0.5f * 1.44269504088896341f;  // of squares in round coordinates, to base 2
constexpr float kAlphaMax = 0.99f;
constexpr float kTransmittanceMin = 1e-4f;
constexpr double kFrustumMargin = 0.3;
constexpr float kCompensationMin2 = 0.005f * 0.005f;
constexpr float kCovarianceMax = 1e18f;  // pixels^2
constexpr float kDepthMax = 1e18f;       // world units
constexpr float kColourMax = 1e18f;

// Covers the rounding of the edges of boxes, pixels. A pixel inside a box but outside its ellipse costs time only.
constexpr float kPixelSlack = 1e-3f;

// Pixels, inclusive; empty when x1 < x0 or y1 < y0.
struct PixelRange {
  int x0, x1, y0, y1;
  bool empty() const { return x1 < x0 || y1 < y0; }
};

// An ellipse on the screen, one cache line. At the offset (dx, dy) from the mean, its alpha is 2 to the power of
//     log2_opacity - t^2 - e^2,  t = scale_t (dx + slope dy),  e = scale_e dy,
// the quadratic form of docs/numerics.md as a sum of squares: nothing cancels for long thin splats.
// What is multiplied by distances of thousands of pixels has more digits than a float: the mean is a whole pixel and a
// remainder, and the slope, by which a needle turns a distance along it into one across it, is the sum of two floats.
struct alignas(64) ScreenSplat {
  float origin_x, origin_y;  // whole numbers, pixels
  float mean_x, mean_y;      // from the origin, pixels
  float slope, slope_rest;
  float scale_t, scale_e;    // 1 / pixel
  float log2_opacity;        // at least kLog2AlphaMin
  float r, g, b;
  float depth;               // camera-space z
  uint16_t x0, x1, y0, y1;   // pixels whose alpha can reach 1/255, inclusive; x1 < x0 when there are none
  uint32_t row;              // in its own parameter arrays

  PixelRange box() const { return {x0, x1, y0, y1}; }
};
static_assert(sizeof(ScreenSplat) == 64);

// The pixels of a tile that a splat can change, inclusive, relative to its corner: a box, and the rows of it in the left
// and the right half of the tile. A half without any has y1 < y0 there.
struct TileBox {
  uint8_t x0, x1, y0, y1;
  struct {
    uint8_t y0, y1;
  } half[2];
};

// A splat in a tile.
struct TileEntry {
  uint32_t splat;  // in `splats` of its set
  uint32_t slot;   // in `slots` of its set
  TileBox box;
  float middle_t;  // t in the middle of the box
};

// What a (splat, tile) pair adds to the gradient of a splat: sums over the tile's pixels of dL / d colour, dL / d depth
// and, with h = dL / d ln(alpha) of a pixel and (t, e) as in ScreenSplat, of h times the powers of t and e. In these
// coordinates every splat is round; moments of the offsets in pixels would be nearly dependent for a needle. The last two
// are sums of magnitudes, for the statistics: of h t, and of h (t_by_y t + e_by_y e), as dL / d mean_y of a pixel is.
enum GradientTerm { kHt, kHe, kHtt, kHte, kHee, kRed, kGreen, kBlue, kH, kDepth, kPullT, kPullY, kGradientTerms };

struct alignas(64) GradientSlot {
  float terms[16];  // kGradientTerms of them, in a cache line of their own
};

// One set of splats on the screen. Static and dynamic splats are projected, sorted and listed apart, so that statics can
// be kept from one moment to the next; compositing merges the two lists of a tile by depth.
struct ScreenSet {
  int64_t count = 0;  // splats of the set

  Buffer<ScreenSplat> splats;     // [count]; only the places in `visible` are in use
  Buffer<uint32_t> chunk_visible;  // visible splats per chunk of projection
  Buffer<uint32_t> visible;       // [visible_count] places in `splats`, ascending
  int64_t visible_count = 0;
  int64_t entry_bound = 0;  // (splat, cell) pairs, counting all cells of every box: no fewer than entries

  Buffer<uint32_t> order;  // `visible` by depth
  Buffer<TileEntry> entries;  // tile after tile, by depth
  Buffer<uint32_t> tile_begin;  // [tiles + 1] in `entries`
  Buffer<uint32_t> tile_end;    // [tiles] where the last pass from front to back found every pixel finished
  Buffer<uint32_t> first_slot, slot_count;  // [count]: the slots of a splat are consecutive
  Buffer<GradientSlot> slots;               // [entries]
};

}  // namespace hgs
