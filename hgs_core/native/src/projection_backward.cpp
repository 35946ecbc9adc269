// From the gradients of the tiles to the gradients of the parameters.
#include <cstring>

#include "moment.hpp"
#include "thread_pool.hpp"
#include "workspace.hpp"

namespace hgs {
namespace {

// Zero an array of `count` rows, unless nobody wants it.
void clear(float *array, int64_t count, int width, int threads) {
  if (array == nullptr) return;
  constexpr int64_t kBlock = 1 << 14;  // floats
  const int64_t size = count * width;
  parallel_for(threads, (size + kBlock - 1) / kBlock, 1, [&](int64_t block) {
    std::memset(array + block * kBlock, 0, sizeof(float) * std::min(kBlock, size - block * kBlock));
  });
}

void clear(const hgs_static_gradients &g, const StaticMoment &moment, int threads) {
  const int64_t count = moment.count();
  clear(g.means, count, 3, threads);
  clear(g.log_scales, count, 3, threads);
  clear(g.quats, count, 4, threads);
  clear(g.opacity_logits, count, 1, threads);
  clear(g.rgb, count, 3, threads);
}

template <int kCoefficients>
void clear(const hgs_dynamic_gradients &g, const DynamicMoment<kCoefficients> &moment, int threads) {
  const int64_t count = moment.count();
  clear(g.motion, count, 3 * kCoefficients, threads);
  clear(g.rotation, count, 8, threads);
  clear(g.log_scales, count, 3, threads);
  clear(g.opacity_logits, count, 1, threads);
  clear(g.time_centers, count, 1, threads);
  clear(g.time_log_precisions, count, 1, threads);
  clear(g.rgb, count, 3, threads);
}

// Add up the slots of the splats in the lanes, in a fixed order.
void sum_slots(const ScreenSet &set, const uint32_t *splats, int lanes, Vec *sums) {
  alignas(64) float columns[kGradientTerms][kLanes] = {};
  for (int k = 0; k < lanes; ++k) {
    constexpr int kVectors = (kGradientTerms + kLanes - 1) / kLanes;
    Vec total[kVectors] = {};
    const GradientSlot *slot = set.slots.data() + set.first_slot[splats[k]];
    for (uint32_t n = set.slot_count[splats[k]]; n > 0; --n, ++slot) {
      for (int i = 0; i < kVectors; ++i) total[i] += load(slot->terms + i * kLanes);
    }
    for (int c = 0; c < kGradientTerms; ++c) columns[c][k] = total[c / kLanes][c % kLanes];
  }
  for (int c = 0; c < kGradientTerms; ++c) sums[c] = load(columns[c]);
}

void add_statistics(const Rows &rows, int64_t first_row, Vec pull_x, Vec pull_y,
                    const hgs_screen_statistics &statistics) {
  alignas(64) float pulls[kLanes];
  store(pulls, sqrt(pull_x * pull_x + pull_y * pull_y));
  for (int k = 0; k < rows.count; ++k) {
    const int64_t i = first_row + rows.row[k];
    statistics.pull_sum[i] += pulls[k];
    statistics.count[i] += pulls[k] > 0.0F;
  }
}

// Differentiate the visible splats of one set; their rows in the statistics start at `first_row`.
template <class Moment, class Gradients>
void project_set_backward(const Workspace &w, const ScreenSet &set, const Moment &moment, int64_t first_row,
                          const Gradients &gradients, const hgs_screen_statistics *statistics, int threads) {
  clear(gradients, moment, threads);
  const CameraModel model(w.view);
  parallel_for(threads, (set.visible_count + kLanes - 1) / kLanes, 16, [&](int64_t group) {
    const int64_t first = group * kLanes;
    const uint32_t *const splats = set.visible.data() + first;
    const Rows rows(static_cast<int>(std::min<int64_t>(kLanes, set.visible_count - first)),
                    [&](int k) { return set.splats[splats[k]].row; });
    Refusal ignored;  // the forward pass has looked
    Vec sums[kGradientTerms];
    sum_slots(set, splats, rows.count, sums);
    const Projection p = project(model, moment.shape(rows, ignored));
    const Round round(p);
    const float root = 1.0f / std::sqrt(kExponentScale);  // moments are in coordinates that are smaller by it
    ScreenGradient g;
    g.mean_x = root * round.t_by_x * sums[kHt];
    g.mean_y = root * (round.t_by_y * sums[kHt] + round.e_by_y * sums[kHe]);
    g.round_tt = sums[kHtt] * (1.0f / kExponentScale);
    g.round_te = sums[kHte] * (1.0f / kExponentScale);
    g.round_ee = sums[kHee] * (1.0f / kExponentScale);
    g.log_opacity = sums[kH];
    g.depth = sums[kDepth];
    const Vec d_opacity = sums[kH] / moment.opacity(rows, ignored);
    moment.backward(rows, project_backward(model, p, round, g), d_opacity, sums + kRed, gradients);
    if (statistics != nullptr) {
      const Vec pull_x = root * round.t_by_x * sums[kPullT], pull_y = sums[kPullY] * (1.0f / kExponentScale);
      add_statistics(rows, first_row, pull_x, pull_y, *statistics);
    }
  });
}

}  // namespace

void project_statics_backward(const Workspace &w, const hgs_static_splats &splats, const hgs_static_gradients &gradients,
                              const hgs_screen_statistics *statistics, int threads) {
  project_set_backward(w, w.statics, StaticMoment{splats}, 0, gradients, statistics, threads);
}

void project_dynamics_backward(const Workspace &w, const hgs_dynamic_splats &splats,
                               const hgs_dynamic_gradients &gradients, const hgs_screen_statistics *statistics,
                               int threads) {
  with_moment(splats, w.view.time, [&](const auto &moment) {
    project_set_backward(w, w.dynamics, moment, w.statics.count, gradients, statistics, threads);
  });
}

}  // namespace hgs
