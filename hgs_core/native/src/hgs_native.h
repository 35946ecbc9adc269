/* C ABI of the HGS kernels. docs/numerics.md defines what they compute.
 *
 * Arrays are contiguous, row-major and float32 unless noted. Pictures are planes: [3][height][width]. Nothing here
 * throws: functions that can fail return an hgs_status. All functions may be called from several threads at once, each
 * with a workspace of its own, and give the same bits for any number of threads. `threads` is at least 1. */
#ifndef HGS_NATIVE_H
#define HGS_NATIVE_H

#include <stdint.h>

#define HGS_STATICS_ANEW 0
#define HGS_STATICS_KEEP 1
#define HGS_STATICS_REUSE 2
#define HGS_ABI_VERSION 12
#define HGS_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

enum hgs_status {
  HGS_OK = 0,
  HGS_OUT_OF_MEMORY = 1,
  HGS_TOO_MANY_TILE_ENTRIES = 2, /* more than 2^31 - 1 (splat, tile) pairs */
  HGS_FAILED = 3,                /* for instance no thread could be started */
  HGS_REFUSED = 4                /* a parameter of a splat that was looked at is NaN or infinite, or a colour above 1e18 */
};

/* An undistorted pinhole camera, OpenCV axes. A world point X is at (x, y, z) = rotation X + translation in the camera
 * and at pixel (fx x / z + cx, fy y / z + cy). Doubles, because positions on the screen are computed in them. */
typedef struct hgs_camera {
  int32_t width, height; /* pixels, 1 to HGS_MAX_SIDE */
  double fx, fy, cx, cy; /* pixels */
  double rotation[9];    /* [3][3], world to camera */
  double translation[3];
  double near_plane; /* world units; splats whose centre has a smaller z are not drawn */
} hgs_camera;

#define HGS_MAX_SIDE 65535

/* What to draw, besides the splats. */
typedef struct hgs_view {
  hgs_camera camera;
  double time;         /* normalised time of the dynamic splats */
  float background[3]; /* colour behind everything */
  int32_t antialiased; /* 1: opacities are multiplied by what the low-pass filter spreads them over; 0: they are not */
  /* [ceil(height / 16)][ceil(width / 16)] bytes; tiles that are 0 show the background. NULL = draw all. */
  const uint8_t *tile_mask;
  /* HGS_STATICS_KEEP: the statics are listed in all tiles, whatever the mask. HGS_STATICS_REUSE: camera, magnification,
   * antialiasing and static splats are those of the last rendering with HGS_STATICS_KEEP, which succeeded: the statics are
   * neither projected nor listed again. The mask may be another each time. */
  int32_t statics_use;
  /* What is at (x, y, z) in the camera shows max(0, (a x + b y + c z + d) / z) times as large as in the pictures that
   * made it, with a, b, c, d in this order; all 0 = never larger. */
  double magnification[4];
} hgs_view;

/* A picture, or the gradient of one. */
typedef struct hgs_picture {
  float *rgb;   /* [3][height][width] background included; not clamped */
  float *alpha; /* [height][width] 1 - transmittance */
  float *depth; /* [height][width] sum of weight times camera-space z; NULL = not wanted */
} hgs_picture;

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
  int64_t coefficients;             /* K, of the motion: 4 or 6 */
  const float *motion;              /* [M][K][3] polynomial of the mean, world units, constant first */
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
  float *pull_sum; /* += the norm over x and y of the sum over pixels of |dL / d screen mean|, the mean in pixels */
  int32_t *count;  /* += 1 if that is not zero: a hidden splat is not counted */
} hgs_screen_statistics;

/* What the last calls on a workspace did. */
typedef struct hgs_measurements {
  double project, bin, composite;                 /* seconds of hgs_rasterize */
  double composite_backward, project_backward;    /* seconds of hgs_rasterize_backward */
  int64_t visible_static, visible_dynamic;        /* splats */
  int64_t tile_entries;                           /* (splat, tile) pairs */
  int64_t evaluations;                            /* (splat, pixel) pairs composited, whole vectors of pixels counted */
} hgs_measurements;

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

/* Render both sets.
 *
 * picture: NULL if hgs_contributions is all that is wanted: splats are projected and listed, and nothing is drawn. */
HGS_API int32_t hgs_rasterize(hgs_workspace *workspace, const hgs_view *view, const hgs_static_splats *statics,
                              const hgs_dynamic_splats *dynamics, int32_t threads, const hgs_picture *picture);

/* Differentiate the last hgs_rasterize of `workspace`, which may be done several times.
 *
 * statics, dynamics: the parameters given to hgs_rasterize, unchanged.
 * picture: what it returned.  gradient: dL / d of the same; alpha and depth may be NULL (zero), depth has to be if the
 *     picture has none.
 * grad_statics, grad_dynamics: the gradient set; NULL leaves that set out altogether.
 * statistics: may be NULL. */
HGS_API int32_t hgs_rasterize_backward(hgs_workspace *workspace, const hgs_static_splats *statics,
                                       const hgs_dynamic_splats *dynamics, const hgs_picture *picture,
                                       const hgs_picture *gradient, const hgs_static_gradients *grad_statics,
                                       const hgs_dynamic_gradients *grad_dynamics,
                                       const hgs_screen_statistics *statistics, int32_t threads);

/* What every splat contributes to the picture of the last hgs_rasterize of `workspace`, drawn or not.
 *
 * total: out, [N + M], statics first: sum of the splat's weights over the pixels.  peak: out, [N + M]: the largest. */
HGS_API int32_t hgs_contributions(hgs_workspace *workspace, int32_t threads, float *total, float *peak);

HGS_API void hgs_measure(const hgs_workspace *workspace, hgs_measurements *measurements);

/* Floating-point operations per second that `threads` threads reach when they do nothing but fused multiply-adds of
 * this library's vector width (each counts twice), measured for about `seconds`; 0 if the threads cannot be started. */
HGS_API double hgs_fma_peak(int32_t threads, double seconds);

/* The mean over pixels and channels of the structural similarity of two pictures.
 *
 * image, target: [3][height][width], data range 1.  mean: out, one double. */
HGS_API int32_t hgs_ssim(const float *image, const float *target, int32_t width, int32_t height, int32_t threads,
                         double *mean);

/* (1 - dssim_weight) mean |image - target| + dssim_weight (1 - SSIM(image, target)), and its gradient. SSIM is the mean
 * over the windows around every second pixel of every third row, beginning with the first.
 *
 * image, target: [3][height][width], data range 1.  loss: out, one double.
 * gradient: out, [3][height][width], dL / d image; must not overlap the inputs. */
HGS_API int32_t hgs_l1_dssim(const float *image, const float *target, int32_t width, int32_t height,
                             float dssim_weight, int32_t threads, double *loss, float *gradient);

/* What a camera makes of colours: A (gain rgb) + b, where its lens leaves the gain 1 + f r^2 + g r^4 of the light at the
 * distance r from the principal point (cx, cy). */
typedef struct hgs_camera_colours {
  float affine[12];     /* [3][4] rows of [A | b] */
  float falloff[2];     /* f, g; 0, 0: nothing is darkened */
  double cx, cy;        /* pixels; outside the picture if that is a part of the camera's */
  double half_diagonal; /* of the camera's whole picture, pixels: the unit of r */
} hgs_camera_colours;

/* picture: [3][height][width] as a scene shows it.  shown: out, as the camera does; must not overlap the picture. */
HGS_API int32_t hgs_camera_shown(const hgs_camera_colours *colours, const float *picture, int32_t width, int32_t height,
                                 int32_t threads, float *shown);

/* Differentiate hgs_camera_shown of a picture.
 *
 * gradient: [3][height][width] dL / d shown.  pulled: out, dL / d picture; must not overlap the inputs.
 * affine, falloff: out, [3][4] and [2], the gradients towards the fields of that name. */
HGS_API int32_t hgs_camera_shown_backward(const hgs_camera_colours *colours, const float *picture, const float *gradient,
                                          int32_t width, int32_t height, int32_t threads, float *pulled, float *affine,
                                          float *falloff);

/* One step of RMSprop (Tieleman and Hinton 2012) on rows of `width` values, in place.
 *
 * gradients: [rows][width], one after the other.
 * row_of: [rows] the rows of `parameters` and `moments` that they are for, none twice; NULL = 0, 1, 2, ...
 * moments: state, zero before the first step: mean squares of the gradients.
 * decays: [rows] what is left of the moments; NULL = beta for all. Squares gain 1 - beta.
 * factors: [ceil(rows width / values_per_factor)] of the learning rate, one for so many values in turn; NULL = 1 for all.
 * correction: 1 - beta^step, by which the moments are divided. */
HGS_API int32_t hgs_rmsprop(int64_t rows, int64_t width, const int64_t *row_of, float *parameters,
                            const float *gradients, float *moments, const float *decays, double beta,
                            const float *factors, int64_t values_per_factor, double learning_rate, double correction,
                            double epsilon, int32_t threads);

/* A picture that a plane sweep compares with. */
typedef struct hgs_sweep_source {
  const float *grey;     /* [height][width] */
  int32_t width, height; /* at least 2 */
  double map[12];        /* [3][4]: (x, y) of the swept picture at depth z is at (u / w, v / w) here, pixels, where
                            (u, v, w) = map (x z, y z, z, 1) */
} hgs_sweep_source;

/* The depth at which the windows of 9x9 pixels around every pixel agree best with those of other pictures.
 *
 * grey: [height][width] the swept picture, data range 1.
 * sources: [count] other pictures, of which at every depth the three that fit best count.
 * depths: [depth_count] that are tried, 3 at least, ascending or descending, evenly in what they move on the screen.
 * places: out, [height][width] the best place among the depths, 0 to depth_count - 1, between two where that fits better.
 * costs: out, [height][width] how badly the windows match there: 0 alike, 0.5 unlike or blank, 0.9 seen by no source. */
HGS_API int32_t hgs_plane_sweep(const float *grey, int32_t width, int32_t height, const hgs_sweep_source *sources,
                                int32_t count, const double *depths, int32_t depth_count, float *places, float *costs);

/* What pixels are compared by in a coarse sweep: the means over 3x3 and over 7x7 pixels, rounded down; black outside.
 *
 * picture: [height][width][3].  descriptors: out, [height][width][6]. */
HGS_API int32_t hgs_colour_descriptors(const uint8_t *picture, int32_t width, int32_t height, uint8_t *descriptors);

/* A picture that a coarse sweep compares with. */
typedef struct hgs_colour_source {
  const uint8_t *descriptors; /* [height][width][6] */
  int32_t width, height;
  double map[12]; /* [3][4]: a point of the world is at (u / w, v / w), pixels, where (u, v, w) = map (x, y, z, 1) */
} hgs_colour_source;

/* A picture that says which points may exist. */
typedef struct hgs_hull_view {
  const uint8_t *mask; /* [height][width] not zero where they may */
  int32_t width, height;
  double map[12];
} hgs_hull_view;

/* How badly points along rays fit what other pictures show there.
 *
 * origin: [3] where the rays start.  rays: [count][3] to depth 1.  own: [count][6] what the points should look like.
 * depths: [depth_count].
 * sources: [source_count] of which the one that fits worst does not count, unless it is the only one.
 * hull: [hull_count] views, or 0: points of which less than `hull_share` of those that they fall in say that they may
 *     exist, or that fall in none, do not.
 * blind: the difference, levels of 255, that a source counts with which a point falls outside of.
 * costs: out, [count][depth_count] mean differences of descriptors, levels of 255; infinite outside of the hull. */
HGS_API int32_t hgs_colour_sweep(const double *origin, const double *rays, const uint8_t *own, int64_t count,
                                 const double *depths, int32_t depth_count, const hgs_colour_source *sources,
                                 int32_t source_count, const hgs_hull_view *hull, int32_t hull_count,
                                 double hull_share, float blind, float *costs);

/* Blends of four neighbouring pixels, rounded to bytes.
 *
 * picture: [height][width][channels], 1 or 3 channels.
 * corners: [count] number of the upper left pixel; it has neighbours to the right and below.
 * right, lower: [count] shares of the right and of the lower pixels.  out: [count][channels]. */
HGS_API int32_t hgs_resample(const uint8_t *picture, int32_t width, int32_t channels, const int32_t *corners,
                             const float *right, const float *lower, int64_t count, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
