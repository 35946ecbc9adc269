/* C ABI of the HGS kernels. docs/numerics.md defines what they compute.
 *
 * Arrays are contiguous, row-major and float32 unless noted. Pictures are planes: [3][height][width]. Nothing here
 * throws: functions that can fail return an hgs_status. All functions may be called from several threads at once, each
 * with a workspace of its own, and give the same bits for any number of threads. */
#ifndef HGS_NATIVE_H
#define HGS_NATIVE_H

#include <stdint.h>

#define HGS_ABI_VERSION 2
#define HGS_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

enum hgs_status {
  HGS_OK = 0,
  HGS_OUT_OF_MEMORY = 1,
  HGS_TOO_MANY_TILE_ENTRIES = 2, /* more than 2^31 - 1 (splat, tile) pairs */
  HGS_FAILED = 3                 /* for instance no thread could be started */
};

/* An undistorted pinhole camera, OpenCV axes. A world point X is at (x, y, z) = rotation X + translation in the camera
 * and at pixel (fx x / z + cx, fy y / z + cy). */
typedef struct hgs_camera {
  int32_t width, height; /* pixels */
  float fx, fy, cx, cy;  /* pixels */
  float rotation[9];     /* [3][3], world to camera */
  float translation[3];
  float near_plane; /* world units; splats whose centre has a smaller z are not drawn */
} hgs_camera;

/* Splats that never change. */
typedef struct hgs_static_splats {
  int64_t count;               /* N, below 2^31; the arrays may be NULL when it is 0 */
  const float *means;          /* [N][3] world units */
  const float *log_scales;     /* [N][3] ln of world units */
  const float *quats;          /* [N][4] w, x, y, z, of any length */
  const float *opacity_logits; /* [N] */
  const float *rgb;            /* [N][3] */
} hgs_static_splats;

/* Splats that are evaluated at a normalised time. */
typedef struct hgs_dynamic_splats {
  int64_t count;                    /* M, below 2^31; the arrays may be NULL when it is 0 */
  const float *motion;              /* [M][4][3] polynomial of the mean, world units */
  const float *rotation;            /* [M][2][4] polynomial of the quaternion */
  const float *log_scales;          /* [M][3] ln of world units */
  const float *opacity_logits;      /* [M] */
  const float *time_centers;        /* [M] normalised time */
  const float *time_log_precisions; /* [M] ln of 1 / normalised time^2 */
  const float *rgb;                 /* [M][3] */
} hgs_dynamic_splats;

/* Gradients, shaped like the parameters of the same name. They are overwritten, every row; NULL = not wanted. */
typedef struct hgs_static_gradients {
  float *means, *log_scales, *quats, *opacity_logits, *rgb;
} hgs_static_gradients;

typedef struct hgs_dynamic_gradients {
  float *motion, *rotation, *log_scales, *opacity_logits, *time_centers, *time_log_precisions, *rgb;
} hgs_dynamic_gradients;

/* Added to for every splat of the gradient set whose extent overlaps the picture. [N + M], statics first. */
typedef struct hgs_screen_statistics {
  float *grad_norm_sum; /* += |dL / d screen mean|, the mean in pixels */
  int32_t *count;       /* += 1 */
  float *max_radius;    /* max= 3 standard deviations along the splat's major axis on the screen, pixels */
} hgs_screen_statistics;

/* The buffers of one rendering, and what its backward pass needs to know. */
typedef struct hgs_workspace hgs_workspace;

HGS_API int32_t hgs_abi_version(void);

/* The x86-64 microarchitecture level (1 to 4) that processor and operating system support; 0 on other processors. */
HGS_API int32_t hgs_cpu_level(void);

/* A status in words; the string is static. */
HGS_API const char *hgs_status_message(int32_t status);

/* NULL when out of memory. Buffers grow as needed and are kept until the workspace is destroyed. */
HGS_API hgs_workspace *hgs_workspace_create(void);
HGS_API void hgs_workspace_destroy(hgs_workspace *workspace);

/* Render both sets at normalised `time`.
 *
 * tile_mask: [ceil(height / 16)][ceil(width / 16)] bytes; tiles that are 0 show the background. NULL = draw all.
 * background: [3].  threads: at least 1.
 * rgb: out, [3][height][width].  alpha: out, [height][width]. */
HGS_API int32_t hgs_rasterize(hgs_workspace *workspace, const hgs_camera *camera, const hgs_static_splats *statics,
                              const hgs_dynamic_splats *dynamics, float time, const float *background,
                              const uint8_t *tile_mask, int32_t threads, float *rgb, float *alpha);

/* Differentiate the last hgs_rasterize of `workspace`, which may be done several times.
 *
 * statics, dynamics: the parameters given to hgs_rasterize, unchanged.
 * rgb, alpha: what it returned.  grad_rgb, grad_alpha: dL / d of the same; grad_alpha may be NULL (zero).
 * grad_statics, grad_dynamics: the gradient set; NULL leaves that set out altogether.
 * statistics: may be NULL. */
HGS_API int32_t hgs_rasterize_backward(hgs_workspace *workspace, const hgs_static_splats *statics,
                                       const hgs_dynamic_splats *dynamics, const float *rgb, const float *alpha,
                                       const float *grad_rgb, const float *grad_alpha,
                                       const hgs_static_gradients *grad_statics,
                                       const hgs_dynamic_gradients *grad_dynamics,
                                       const hgs_screen_statistics *statistics, int32_t threads);

/* (1 - dssim_weight) mean |image - target| + dssim_weight (1 - SSIM(image, target)), and its gradient.
 *
 * image, target: [3][height][width], data range 1.  loss: out, one double.
 * gradient: out, [3][height][width], dL / d image; must not overlap the inputs. */
HGS_API int32_t hgs_l1_dssim(const float *image, const float *target, int32_t width, int32_t height,
                             float dssim_weight, int32_t threads, double *loss, float *gradient);

/* One step of Adam (Kingma and Ba 2015, algorithm 1) on n values, in place.
 *
 * first_moments, second_moments: state, zero before the first step.  step: 1 for the first step. */
HGS_API int32_t hgs_adam(int64_t n, float *parameters, const float *gradients, float *first_moments,
                         float *second_moments, double learning_rate, double beta1, double beta2, double epsilon,
                         int64_t step, int32_t threads);

#ifdef __cplusplus
}
#endif
#endif
