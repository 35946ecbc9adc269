// Culling and projection of a set into the workspace.
#include <atomic>

#include "moment.hpp"
#include "thread_pool.hpp"
#include "workspace.hpp"

namespace hgs {
namespace {

constexpr int kChunk = 1024;  // splats that a thread takes at a time; their visible ones are stored together

// The pixels along one axis whose centres lie within `half` of the mean, limited to the picture.
struct Extent {
  Vec first, last;

  Extent(Vec origin, Vec mean, Vec half, int size) {
    constexpr float kFar = 1 << 21;
    const Vec side = broadcast(static_cast<float>(size));
    const Vec low = ceil(clamp(mean - half - (0.5f + kPixelSlack), -kFar, kFar)) + origin;
    const Vec high = floor(clamp(mean + half - (0.5f - kPixelSlack), -kFar, kFar)) + origin;
    // An empty extent ends up beyond the edges, and is then made (1, 0).
    first = max(low, Vec{});
    last = min(high, side - 1.0f);
    const Mask some = greater_equal(last, first);
    first = select(some, first, broadcast(1.0f));
    last = keep(some, last);
  }

  Vec cells() const { return floor(last * (1.0f / kCell)) - floor(first * (1.0f / kCell)) + 1.0f; }
};

struct Chunk {
  const CameraModel &model;
  ScreenSplat *out;       // the next visible splat
  int64_t entry_bound = 0;
  Refusal refusal;

  // Project the candidates and append those that are visible.
  template <class Moment>
  void project_rows(const Moment &moment, const Rows &rows) {
    const hgs_camera &camera = model.exact;
    const Shape shape = moment.shape(rows, refusal);
    const Projection p = project(model, shape);
    Vec opacity = moment.opacity(rows, refusal);
    if (model.antialiased) opacity *= sqrt(max(compensation2(p), broadcast(kCompensationMin2)));
    const Vec log2_opacity = log2(opacity);
    const Vec reach = (log2_opacity - kLog2AlphaMin) * (2.0f * kLn2);
    const Vec half_x = sqrt(reach * p.cov_xx), half_y = sqrt(reach * p.cov_yy);

    constexpr double kFar = 1 << 22;
    const Wide origin_x = round(clamp(p.mean_x, -kFar, kFar)), origin_y = round(clamp(p.mean_y, -kFar, kFar));
    const Vec from_x = narrow(origin_x), from_y = narrow(origin_y);
    const Vec mean_x = narrow(p.mean_x - origin_x), mean_y = narrow(p.mean_y - origin_y);
    const Extent columns(from_x, mean_x, half_x, camera.width), lines(from_y, mean_y, half_y, camera.height);

    // Written so that a splat with NaN anywhere fails.
    const Vec zero{}, limit = broadcast(kCovarianceMax);
    Mask seen = both(greater_equal(p.distance_to_near_plane, zero), greater(p.conic_determinant, zero));
    seen = both(seen, both(greater(limit, p.cov_xx), greater(limit, p.cov_yy)));
    seen = both(seen, greater_equal(broadcast(kDepthMax), p.z));
    seen = both(seen, greater_equal(opacity, broadcast(kAlphaMin)));
    seen = both(seen, both(greater(from_x + mean_x + half_x, zero), greater(from_y + mean_y + half_y, zero)));
    seen = both(seen, both(greater(broadcast(static_cast<float>(camera.width)), from_x + mean_x - half_x),
                           greater(broadcast(static_cast<float>(camera.height)), from_y + mean_y - half_y)));
    const uint32_t seen_lanes = lane_bits(seen) & ((2u << (rows.count - 1)) - 1);
    if (seen_lanes == 0) return;

    const Wide exact = exact_slope(model, shape, p);
    const Vec slope = narrow(exact), slope_rest = narrow(exact - widen(slope));
    const Vec scale_t = sqrt(kExponentScale * p.conic_xx), scale_e = sqrt(kExponentScale / p.cov_yy);
    const Vec values[] = {from_x, from_y, mean_x, mean_y, slope, slope_rest, scale_t, scale_e, log2_opacity,
                          shape.rgb[0], shape.rgb[1], shape.rgb[2], p.z, columns.first, columns.last, lines.first,
                          lines.last, columns.cells() * lines.cells()};
    constexpr int kValues = sizeof(values) / sizeof(values[0]);
    alignas(64) float f[kValues][kLanes];
    for (int i = 0; i < kValues; ++i) store(f[i], values[i]);
    const auto pixel = [](float x) { return static_cast<uint16_t>(x); };
    for (int k = 0; k < rows.count; ++k) {
      if (!(seen_lanes >> k & 1)) continue;
      *out++ = {f[0][k], f[1][k], f[2][k], f[3][k], f[4][k], f[5][k], f[6][k], f[7][k], f[8][k], f[9][k], f[10][k],
                f[11][k], f[12][k], pixel(f[13][k]), pixel(f[14][k]), pixel(f[15][k]), pixel(f[16][k]), rows.row[k]};
      entry_bound += static_cast<int64_t>(f[17][k]);
    }
  }

  // Project splats [begin, end).
  template <class Moment>
  void project_range(const Moment &moment, int64_t begin, int64_t end) {
    moment.look_at_all(begin, end, refusal);
    // First those that are opaque enough to be seen, so that projection has full vectors to work on.
    uint32_t candidates[kChunk];
    int count = 0;
    for (int64_t i = begin; i < end; i += kLanes) {
      const int lanes = static_cast<int>(std::min<int64_t>(kLanes, end - i));
      const Rows rows(lanes, [&](int k) { return static_cast<uint32_t>(i + k); });
      const uint32_t alive = lane_bits(greater_equal(moment.opacity(rows, refusal), broadcast(kAlphaMin)));
      for (int k = 0; k < lanes; ++k) {
        candidates[count] = rows.row[k];
        count += alive >> k & 1;
      }
    }
    for (int i = 0; i < count; i += kLanes) {
      project_rows(moment, Rows(std::min(kLanes, count - i), [&](int k) { return candidates[i + k]; }));
    }
  }
};

template <class Moment>
hgs_status project_set(const hgs_view &view, const Moment &moment, ScreenSet &set, int threads) {
  const CameraModel model(view);
  const int64_t count = moment.count(), chunks = (count + kChunk - 1) / kChunk;
  set.count = count;
  set.splats.reserve(count);
  set.chunk_visible.reserve(chunks);
  std::atomic<int64_t> entry_bound{0};
  std::atomic<bool> refused{false};
  parallel_for(threads, chunks, 1, [&](int64_t c) {
    const int64_t begin = c * kChunk;
    ScreenSplat *const first = set.splats.data() + begin;
    Chunk chunk{model, first, 0, {}};
    chunk.project_range(moment, begin, std::min(count, begin + kChunk));
    set.chunk_visible[c] = static_cast<uint32_t>(chunk.out - first);
    entry_bound.fetch_add(chunk.entry_bound, std::memory_order_relaxed);
    if (chunk.refusal.found()) refused.store(true, std::memory_order_relaxed);
  });
  if (refused) return HGS_REFUSED;

  uint32_t *const visible = set.visible.reserve(count);
  set.visible_count = 0;
  set.entry_bound = entry_bound;
  for (int64_t c = 0; c < chunks; ++c) {
    const auto begin = static_cast<uint32_t>(c * kChunk);
    for (uint32_t k = 0; k < set.chunk_visible[c]; ++k) visible[set.visible_count++] = begin + k;
  }
  return HGS_OK;
}

}  // namespace

hgs_status project_statics(Workspace &w, const hgs_static_splats &splats, int threads) {
  return project_set(w.view, StaticMoment{splats}, w.statics, threads);
}

hgs_status project_dynamics(Workspace &w, const hgs_dynamic_splats &splats, int threads) {
  return with_moment(splats, w.view.time,
                     [&](const auto &moment) { return project_set(w.view, moment, w.dynamics, threads); });
}

}  // namespace hgs
