// From the gradients of the tiles to the gradients of the parameters.
#include <cstring>

#include "moment.hpp"
#include "thread_pool.hpp"

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

void clear(const hgs_static_gradients &g, int64_t count, int threads) {
  clear(g.means, count, 3, threads);
  clear(g.log_scales, count, 3, threads);
  clear(g.quats, count, 4, threads);
  clear(g.opacity_logits, count, 1, threads);
  clear(g.rgb, count, 3, threads);
}

void clear(const hgs_dynamic_gradients &g, int64_t count, int threads) {
  clear(g.motion, count, 12, threads);
  clear(g.rotation, count, 8, threads);
  clear(g.log_scales, count, 3, threads);
  clear(g.opacity_logits, count, 1, threads);
  clear(g.time_centers, count, 1, threads);
  clear(g.time_log_precisions, count, 1, threads);
  clear(g.rgb, count, 3, threads);
}

// Add up the slots of the splats in the lanes, in a fixed order.
void sum_slots(const Workspace &w, const uint32_t *splats, int lanes, Vec *sums) {
  alignas(64) float columns[kGradientTerms][kLanes] = {};
  for (int k = 0; k < lanes; ++k) {
    float total[kGradientTerms] = {};
    const GradientSlot *slot = w.slots.data() + w.first_slot[splats[k]];
    for (uint32_t n = w.slot_count[splats[k]]; n > 0; --n, ++slot) {
      for (int c = 0; c < kGradientTerms; ++c) total[c] += slot->terms[c];
    }
    for (int c = 0; c < kGradientTerms; ++c) columns[c][k] = total[c];
  }
  for (int c = 0; c < kGradientTerms; ++c) sums[c] = load(columns[c]);
}

// 3 standard deviations along the major axis: the root of the covariance's larger eigenvalue.
Vec screen_radius(const Projection &p) {
  const Vec half_difference = 0.5f * (p.cov_xx - p.cov_yy);
  return 3.0f * sqrt(0.5f * (p.cov_xx + p.cov_yy) + sqrt(half_difference * half_difference + p.cov_xy * p.cov_xy));
}

void add_statistics(const Rows &rows, int64_t first_row, const Projection &p, const ScreenGradient &g,
                    const hgs_screen_statistics &statistics) {
  alignas(64) float norms[kLanes], radii[kLanes];
  store(norms, sqrt(g.mean_x * g.mean_x + g.mean_y * g.mean_y));
  store(radii, screen_radius(p));
  for (int k = 0; k < rows.count; ++k) {
    const int64_t i = first_row + rows.row[k];
    statistics.grad_norm_sum[i] += norms[k];
    statistics.count[i] += 1;
    statistics.max_radius[i] = std::max(statistics.max_radius[i], radii[k]);
  }
}

// Differentiate the visible splats [begin, end) of one set; their rows in the statistics start at `first_row`.
template <class Moment, class Gradients>
void project_set_backward(const Workspace &w, const Moment &moment, int64_t begin, int64_t end, int64_t first_row,
                          const Gradients &gradients, const hgs_screen_statistics *statistics, int threads) {
  clear(gradients, moment.count(), threads);
  const CameraModel model(w.camera);
  parallel_for(threads, (end - begin + kLanes - 1) / kLanes, 16, [&](int64_t group) {
    const int64_t first = begin + group * kLanes;
    const uint32_t *const splats = w.visible.data() + first;
    const Rows rows(static_cast<int>(std::min<int64_t>(kLanes, end - first)),
                    [&](int k) { return w.splats[splats[k]].row; });
    Vec sums[kGradientTerms];
    sum_slots(w, splats, rows.count, sums);
    const Projection p = project(model, moment.shape(rows));
    ScreenGradient g;
    g.mean_x = p.conic_xx * sums[kHdx] + p.conic_xy * sums[kHdy];
    g.mean_y = p.conic_xy * sums[kHdx] + p.conic_yy * sums[kHdy];
    g.conic_xx = -0.5f * sums[kHdx2];
    g.conic_xy = -sums[kHdxdy];
    g.conic_yy = -0.5f * sums[kHdy2];
    const Vec d_opacity = sums[kH] / moment.opacity(rows);
    moment.backward(rows, project_backward(model, p, g), d_opacity, sums + kRed, gradients);
    if (statistics != nullptr) add_statistics(rows, first_row, p, g, *statistics);
  });
}

}  // namespace

void project_splats_backward(const Workspace &w, const hgs_static_splats &statics, const hgs_dynamic_splats &dynamics,
                             const hgs_static_gradients *grad_statics, const hgs_dynamic_gradients *grad_dynamics,
                             const hgs_screen_statistics *statistics, int threads) {
  if (grad_statics != nullptr) {
    project_set_backward(w, StaticMoment{statics}, 0, w.visible_static, 0, *grad_statics, statistics, threads);
  }
  if (grad_dynamics != nullptr) {
    project_set_backward(w, DynamicMoment{dynamics, w.time}, w.visible_static, w.visible_count, w.static_count,
                         *grad_dynamics, statistics, threads);
  }
}

}  // namespace hgs
