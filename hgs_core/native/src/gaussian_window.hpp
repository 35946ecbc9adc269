// The window of SSIM (docs/numerics.md, "Loss") and its constants.
#pragma once

namespace hgs {

constexpr int kRadius = 5;  // pixels
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

// Half of a Gaussian with sigma 1.5 pixels, centre first; all taps add up to 1.
constexpr float kGaussian[kRadius + 1] = {0.266011715f,  0.213005543f,   0.109360687f,
                                          0.0360007733f, 0.00759875821f, 0.00102838012f};

}  // namespace hgs
