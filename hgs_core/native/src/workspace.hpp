// The state of one rendering, and its steps.
#pragma once

#include <cstdint>
#include <vector>

#include "screen.hpp"

namespace hgs {

// A splat in a tile, while it is being sorted into the tile's list.
struct Emission {
  uint32_t splat;
  uint32_t tile;
  TileBox box;
  float middle_t;
};

// The emissions of one thread, which has a consecutive part of the splats in order of depth.
struct ThreadEmissions {
  Buffer<Emission> emissions;
  size_t count = 0;
  Buffer<uint32_t> tile_counts;  // [tiles]
};

// Reused by every sort and listing; nothing in it outlives them.
struct BinningScratch {
  Buffer<uint64_t> keys, other_keys;  // depth, then index
  Buffer<uint32_t> digit_counts;      // [threads][digits]
  std::vector<ThreadEmissions> threads;
};

}  // namespace hgs

struct hgs_workspace {
  hgs_view view{};
  int tiles_x = 0, tiles_y = 0;
  bool depth = false;  // the picture has one
  hgs::ScreenSet statics, dynamics;
  hgs::BinningScratch scratch;
  hgs_measurements seconds{};

  int width() const { return view.camera.width; }
  int height() const { return view.camera.height; }
  int tile_count() const { return tiles_x * tiles_y; }
  // The cells of a tile that are to be drawn: bits 0 and 1 for the upper left and right one, 2 and 3 for the lower ones.
  unsigned cells_drawn(int tile_x, int tile_y) const {
    if (view.tile_mask == nullptr) return 15;
    const int cells_x = (width() + hgs::kCell - 1) / hgs::kCell, cells_y = (height() + hgs::kCell - 1) / hgs::kCell;
    unsigned drawn = 0;
    for (int i = 0; i < 4; ++i) {
      const int x = 2 * tile_x + i % 2, y = 2 * tile_y + i / 2;
      if (x < cells_x && y < cells_y && view.tile_mask[y * cells_x + x] != 0) drawn |= 1u << i;
    }
    return drawn;
  }
  int64_t entry_count(const hgs::ScreenSet &set) const {
    return set.tile_begin.data() == nullptr ? 0 : set.tile_begin[tile_count()];
  }
};

namespace hgs {

using Workspace = hgs_workspace;

// The steps of a rendering, in this order; statics that are reused skip the first two.
hgs_status project_statics(Workspace &w, const hgs_static_splats &splats, int threads);
hgs_status project_dynamics(Workspace &w, const hgs_dynamic_splats &splats, int threads);
void list_by_tile(Workspace &w, ScreenSet &set, int threads);
void composite(Workspace &w, const hgs_picture &picture, int threads);

// The steps of its derivative, in this order.
struct GradientSet {
  bool statics, dynamics;
};
void composite_backward(Workspace &w, const hgs_picture &picture, const hgs_picture &gradient, GradientSet wanted,
                        bool pulls, int threads);
void project_statics_backward(const Workspace &w, const hgs_static_splats &splats, const hgs_static_gradients &gradients,
                              const hgs_screen_statistics *statistics, int threads);
void project_dynamics_backward(const Workspace &w, const hgs_dynamic_splats &splats,
                               const hgs_dynamic_gradients &gradients, const hgs_screen_statistics *statistics,
                               int threads);

void sum_contributions(Workspace &w, int threads, float *total, float *peak);

}  // namespace hgs
