#include "api.hpp"

#include <chrono>
#include <limits>
#include <utility>

#include "simd.hpp"
#include "workspace.hpp"

namespace hgs {
namespace {

class Stopwatch {
 public:
  // Seconds since the last lap.
  double lap() {
    const auto now = Clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

// Pixels that the forward pass computed for one set, whole vectors counted.
int64_t evaluations(const Workspace &w, const ScreenSet &set) {
  if (set.tile_begin.data() == nullptr) return 0;
  int64_t vectors = 0;
  for (int tile = 0; tile < w.tile_count(); ++tile) {
    for (uint32_t e = set.tile_begin[tile]; e < set.tile_end[tile]; ++e) {
      const TileBox &box = set.entries[e].box;
      for (int block = box.x0 / kLanes; block <= box.x1 / kLanes; ++block) {
        const auto &half = box.half[block * kLanes / kCell];
        vectors += half.y1 - half.y0 + 1;
      }
    }
  }
  return vectors * kLanes;
}

}  // namespace
}  // namespace hgs

extern "C" {

int32_t hgs_abi_version(void) { return HGS_ABI_VERSION; }

const char *hgs_status_message(int32_t status) {
  switch (status) {
    case HGS_OK: return "no error";
    case HGS_OUT_OF_MEMORY: return "out of memory in the native kernels";
    case HGS_TOO_MANY_TILE_ENTRIES: return "the splats cover more than 2^31 - 1 tiles: render fewer, smaller or less";
    case HGS_REFUSED: return "a parameter of a splat is not finite, or a colour is beyond 1e18";
    default: return "the native kernels failed: could a thread not be started?";
  }
}

hgs_workspace *hgs_workspace_create(void) { return new (std::nothrow) hgs_workspace; }

void hgs_workspace_destroy(hgs_workspace *workspace) { delete workspace; }

int32_t hgs_rasterize(hgs_workspace *workspace, const hgs_view *view, const hgs_static_splats *statics,
                      const hgs_dynamic_splats *dynamics, int32_t threads, const hgs_picture *picture) {
  return hgs::guarded([&] {
    hgs::Workspace &w = *workspace;
    w.view = *view;
    w.tiles_x = (w.width() + hgs::kTile - 1) / hgs::kTile;
    w.tiles_y = (w.height() + hgs::kTile - 1) / hgs::kTile;
    w.depth = picture != nullptr && picture->depth != nullptr;
    w.seconds = {};
    hgs::Stopwatch watch;
    const bool keep_statics = view->statics_use == HGS_STATICS_REUSE;
    hgs_status status = keep_statics ? HGS_OK : hgs::project_statics(w, *statics, threads);
    if (status == HGS_OK) status = hgs::project_dynamics(w, *dynamics, threads);
    if (status != HGS_OK) return status;
    w.seconds.project = watch.lap();
    // Boxes bound the number of entries from above, before anything is allocated for them.
    if (w.statics.entry_bound + w.dynamics.entry_bound > std::numeric_limits<int32_t>::max()) {
      return HGS_TOO_MANY_TILE_ENTRIES;
    }
    if (!keep_statics) hgs::list_by_tile(w, w.statics, threads);
    hgs::list_by_tile(w, w.dynamics, threads);
    w.seconds.bin = watch.lap();
    if (picture != nullptr) hgs::composite(w, *picture, threads);
    w.seconds.composite = watch.lap();
    return HGS_OK;
  });
}

int32_t hgs_rasterize_backward(hgs_workspace *workspace, const hgs_static_splats *statics,
                               const hgs_dynamic_splats *dynamics, const hgs_picture *picture,
                               const hgs_picture *gradient, const hgs_static_gradients *grad_statics,
                               const hgs_dynamic_gradients *grad_dynamics, const hgs_screen_statistics *statistics,
                               int32_t threads) {
  return hgs::guarded([&] {
    hgs::Workspace &w = *workspace;
    const hgs::GradientSet wanted{grad_statics != nullptr, grad_dynamics != nullptr};
    hgs::Stopwatch watch;
    hgs::composite_backward(w, *picture, *gradient, wanted, statistics != nullptr, threads);
    w.seconds.composite_backward = watch.lap();
    if (wanted.statics) hgs::project_statics_backward(w, *statics, *grad_statics, statistics, threads);
    if (wanted.dynamics) hgs::project_dynamics_backward(w, *dynamics, *grad_dynamics, statistics, threads);
    w.seconds.project_backward = watch.lap();
    return HGS_OK;
  });
}

int32_t hgs_contributions(hgs_workspace *workspace, int32_t threads, float *total, float *peak) {
  return hgs::guarded([&] {
    hgs::sum_contributions(*workspace, threads, total, peak);
    return HGS_OK;
  });
}

void hgs_measure(const hgs_workspace *workspace, hgs_measurements *measurements) {
  const hgs::Workspace &w = *workspace;
  *measurements = w.seconds;
  measurements->visible_static = w.statics.visible_count;
  measurements->visible_dynamic = w.dynamics.visible_count;
  measurements->tile_entries = w.entry_count(w.statics) + w.entry_count(w.dynamics);
  measurements->evaluations = hgs::evaluations(w, w.statics) + hgs::evaluations(w, w.dynamics);
}

}  // extern "C"
