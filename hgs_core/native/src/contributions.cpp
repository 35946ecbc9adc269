// How much of the picture every splat makes up: the sum of its weights over the pixels, and the largest of them.
#include <algorithm>

#include "lanes.hpp"
#include "thread_pool.hpp"
#include "tile.hpp"

namespace hgs {
namespace {

struct Contribution {
  float total, peak;
};

// One contribution per slot of each set, in the memory of the gradients, which this overwrites.
Contribution &of_slot(ScreenSet &set, uint32_t slot) { return reinterpret_cast<Contribution *>(set.slots.data())[slot]; }

Contribution visit(const ScreenSplat &s, const TileEntry &entry, const TilePlace &place, OpenCells open, float *T) {
  Vec total{}, peak{};
  blend_splat(s, entry, place, open, T, [&](int, Vec weight) {
    total += weight;
    peak = max(peak, weight);
  });
  float most = 0.0f;
  for (int k = 0; k < kLanes; ++k) most = std::max(most, peak[k]);
  return {sum(total), most};
}

void visit_tile(Workspace &w, int tile) {
  const TilePlace place(w, tile);
  alignas(64) float T[kTilePixels];
  place.start_transmittance(T);
  TileList list = TileList::all(w, tile);
  OpenCells open(w.cells_drawn(tile % w.tiles_x, tile / w.tiles_x));
  for (open.look(T); !list.done() && open.any(); open.look(T)) {
    for (int n = 0; n < kBatch && !list.done(); ++n) {
      const TileList::Item item = list.take();
      of_slot(item.dynamic ? w.dynamics : w.statics, item.entry.slot) = visit(item.splat, item.entry, place, open, T);
    }
  }
  list.stop(w, tile);
  for (ScreenSet *set : {&w.statics, &w.dynamics}) {
    for (uint32_t e = set->tile_end[tile]; e < set->tile_begin[tile + 1]; ++e) of_slot(*set, set->entries[e].slot) = {};
  }
}

void sum_slots(ScreenSet &set, int threads, float *total, float *peak) {
  std::fill_n(total, set.count, 0.0f);
  std::fill_n(peak, set.count, 0.0f);
  parallel_for(threads, set.visible_count, 1024, [&](int64_t i) {
    const uint32_t splat = set.visible[i], row = set.splats[splat].row;
    for (uint32_t k = 0; k < set.slot_count[splat]; ++k) {
      const Contribution &c = of_slot(set, set.first_slot[splat] + k);
      total[row] += c.total;
      peak[row] = std::max(peak[row], c.peak);
    }
  });
}

}  // namespace

void sum_contributions(Workspace &w, int threads, float *total, float *peak) {
  for (ScreenSet *set : {&w.statics, &w.dynamics}) set->slots.reserve(w.entry_count(*set));
  parallel_for(threads, w.tile_count(), 1, [&](int64_t tile) { visit_tile(w, static_cast<int>(tile)); });
  sum_slots(w.statics, threads, total, peak);
  sum_slots(w.dynamics, threads, total + w.statics.count, peak + w.statics.count);
}

}  // namespace hgs
