// Culling and projection of both sets into the workspace.
#include "moment.hpp"
#include "thread_pool.hpp"

namespace hgs {
namespace {

constexpr int kChunk = 1024;  // splats that a thread takes at a time; their visible ones are stored together

int64_t chunks_of(int64_t count) { return (count + kChunk - 1) / kChunk; }

// Project the candidates and append the visible ones to `out`; returns the new end.
template <class Moment>
ScreenSplat *project_rows(const CameraModel &model, const hgs_camera &camera, const Moment &moment, const Rows &rows,
                          ScreenSplat *out) {
  const Projection p = project(model, moment.shape(rows));
  const Vec opacity = moment.opacity(rows), log2_opacity = log2(opacity);
  const Vec reach = (log2_opacity - kLog2AlphaMin) * (2.0f * kLn2);
  const Vec half_x = sqrt(reach * p.cov_xx), half_y = sqrt(reach * p.cov_yy);
  // Written so that a splat with NaN anywhere fails.
  const Vec zero{};
  Mask seen = both(greater_equal(p.z, broadcast(camera.near_plane)), greater(p.conic_determinant, zero));
  seen = both(seen, both(greater(p.mean_x + half_x, zero), greater(p.mean_y + half_y, zero)));
  seen = both(seen, both(greater(broadcast(static_cast<float>(camera.width)), p.mean_x - half_x),
                         greater(broadcast(static_cast<float>(camera.height)), p.mean_y - half_y)));
  const uint32_t seen_lanes = lane_bits(seen);
  if (seen_lanes == 0) return out;

  constexpr float kScale = -0.5f * kLog2E;
  const Vec columns[] = {p.mean_x, p.mean_y, kScale * p.conic_xx, 2.0f * kScale * p.conic_xy, kScale * p.conic_yy,
                         log2_opacity, half_x, half_y, p.conic_determinant, reach, opacity, p.z};
  constexpr int kColumns = sizeof(columns) / sizeof(columns[0]);
  alignas(64) float f[kColumns][kLanes];
  for (int c = 0; c < kColumns; ++c) store(f[c], columns[c]);
  for (int k = 0; k < rows.count; ++k) {
    if (!(seen_lanes >> k & 1)) continue;
    const float *rgb = moment.rgb() + static_cast<size_t>(rows.row[k]) * 3;
    *out++ = {f[0][k], f[1][k], f[2][k], f[3][k], f[4][k], f[5][k],  rgb[0],   rgb[1],
              rgb[2],  f[6][k], f[7][k], f[8][k], f[9][k], f[10][k], f[11][k], rows.row[k]};
  }
  return out;
}

// Project splats [begin, end) to `out`; returns how many are visible.
template <class Moment>
uint32_t project_chunk(const CameraModel &model, const hgs_camera &camera, const Moment &moment, int64_t begin,
                       int64_t end, ScreenSplat *out) {
  // First those that are opaque enough to be seen, so that projection has full vectors to work on.
  uint32_t candidates[kChunk];
  int count = 0;
  for (int64_t i = begin; i < end; i += kLanes) {
    const int lanes = static_cast<int>(std::min<int64_t>(kLanes, end - i));
    const Rows rows(lanes, [&](int k) { return static_cast<uint32_t>(i + k); });
    const uint32_t alive = lane_bits(greater_equal(moment.opacity(rows), broadcast(kAlphaMin)));
    for (int k = 0; k < lanes; ++k) {
      candidates[count] = rows.row[k];
      count += alive >> k & 1;
    }
  }
  ScreenSplat *next = out;
  for (int i = 0; i < count; i += kLanes) {
    const Rows rows(std::min(kLanes, count - i), [&](int k) { return candidates[i + k]; });
    next = project_rows(model, camera, moment, rows, next);
  }
  return static_cast<uint32_t>(next - out);
}

}  // namespace

void project_splats(Workspace &w, const hgs_static_splats &statics, const hgs_dynamic_splats &dynamics, int threads) {
  const CameraModel model(w.camera);
  const int64_t static_chunks = chunks_of(statics.count), chunks = static_chunks + chunks_of(dynamics.count);
  w.splats.reserve(statics.count + dynamics.count);
  w.chunk_counts.reserve(chunks);
  const auto chunk_begin = [&](int64_t c) {  // its first place in `splats`
    return c < static_chunks ? c * kChunk : statics.count + (c - static_chunks) * kChunk;
  };

  parallel_for(threads, chunks, 1, [&](int64_t c) {
    ScreenSplat *const out = w.splats.data() + chunk_begin(c);
    if (c < static_chunks) {
      const int64_t begin = c * kChunk, end = std::min(statics.count, begin + kChunk);
      w.chunk_counts[c] = project_chunk(model, w.camera, StaticMoment{statics}, begin, end, out);
    } else {
      const int64_t begin = (c - static_chunks) * kChunk, end = std::min(dynamics.count, begin + kChunk);
      w.chunk_counts[c] = project_chunk(model, w.camera, DynamicMoment{dynamics, w.time}, begin, end, out);
    }
  });

  uint32_t *visible = w.visible.reserve(statics.count + dynamics.count);
  w.visible_static = w.visible_count = 0;
  for (int64_t c = 0; c < chunks; ++c) {
    const auto begin = static_cast<uint32_t>(chunk_begin(c));
    for (uint32_t k = 0; k < w.chunk_counts[c]; ++k) visible[w.visible_count++] = begin + k;
    if (c < static_chunks) w.visible_static = w.visible_count;
  }
}

}  // namespace hgs
