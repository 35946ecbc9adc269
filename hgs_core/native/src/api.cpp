#include "api.hpp"

#include "workspace.hpp"

extern "C" {

int32_t hgs_abi_version(void) { return HGS_ABI_VERSION; }

const char *hgs_status_message(int32_t status) {
  switch (status) {
    case HGS_OK: return "no error";
    case HGS_OUT_OF_MEMORY: return "out of memory in the native kernels";
    case HGS_TOO_MANY_TILE_ENTRIES: return "the splats cover more than 2^31 - 1 tiles: render fewer, smaller or less";
    default: return "the native kernels failed: could a thread not be started?";
  }
}

hgs_workspace *hgs_workspace_create(void) { return new (std::nothrow) hgs_workspace; }

void hgs_workspace_destroy(hgs_workspace *workspace) { delete workspace; }

int32_t hgs_rasterize(hgs_workspace *workspace, const hgs_camera *camera, const hgs_static_splats *statics,
                      const hgs_dynamic_splats *dynamics, float time, const float *background,
                      const uint8_t *tile_mask, int32_t threads, float *rgb, float *alpha) {
  return hgs::guarded([&] {
    hgs::Workspace &w = *workspace;
    w.camera = *camera;
    w.time = time;
    w.static_count = statics->count;
    w.dynamic_count = dynamics->count;
    w.tiles_x = (camera->width + hgs::kTile - 1) / hgs::kTile;
    w.tiles_y = (camera->height + hgs::kTile - 1) / hgs::kTile;
    for (int c = 0; c < 3; ++c) w.background[c] = background[c];
    hgs::project_splats(w, *statics, *dynamics, threads);
    const hgs_status status = hgs::bin_splats(w, tile_mask, threads);
    if (status == HGS_OK) hgs::composite(w, rgb, alpha, threads);
    return status;
  });
}

int32_t hgs_rasterize_backward(hgs_workspace *workspace, const hgs_static_splats *statics,
                               const hgs_dynamic_splats *dynamics, const float *rgb, const float *alpha,
                               const float *grad_rgb, const float *grad_alpha,
                               const hgs_static_gradients *grad_statics, const hgs_dynamic_gradients *grad_dynamics,
                               const hgs_screen_statistics *statistics, int32_t threads) {
  return hgs::guarded([&] {
    const hgs::GradientSet set{grad_statics != nullptr, grad_dynamics != nullptr};
    hgs::composite_backward(*workspace, rgb, alpha, grad_rgb, grad_alpha, set, threads);
    hgs::project_splats_backward(*workspace, *statics, *dynamics, grad_statics, grad_dynamics, statistics, threads);
    return HGS_OK;
  });
}

}  // extern "C"
