// The list of every tile.
//
// A splat enters the tiles that its visible ellipse reaches (emitter.hpp). Lists are made without atomics: every thread
// emits a consecutive part of the splats in order of depth, and a prefix sum over (tile, thread) tells where its emissions
// go, so the lists do not depend on the number of threads.
#include <algorithm>
#include <utility>

#include "depth_sort.hpp"
#include "emitter.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int64_t kPrefetch = 8;  // splats ahead

}  // namespace

void list_by_tile(Workspace &w, ScreenSet &set, int threads) {
  sort_by_depth(set, w.scratch, threads);
  const int tiles = w.tile_count();
  const int64_t visible = set.visible_count;
  set.first_slot.reserve(set.count);
  uint32_t *const slot_count = set.slot_count.reserve(set.count);
  std::vector<ThreadEmissions> &scratch = w.scratch.threads;
  if (scratch.size() < static_cast<size_t>(threads)) scratch.resize(threads);

  // Lists that are kept serve frames with other masks.
  const bool kept = &set == &w.statics && w.view.statics_use == HGS_STATICS_KEEP;
  parallel_ranges(threads, visible, [&](int thread, int64_t begin, int64_t end) {
    Emitter emitter(w, set, !kept && w.view.tile_mask != nullptr, slot_count, scratch[thread]);
    for (int64_t i = begin; i < end; ++i) {
      __builtin_prefetch(&set.splats[set.order[std::min(i + kPrefetch, end - 1)]]);
      emitter.emit(set.order[i]);
    }
    scratch[thread].count = emitter.finish();
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
