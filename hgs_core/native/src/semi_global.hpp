// The smoothest of the good depths: semi-global matching (Hirschmüller, TPAMI 2008).
#pragma once

#include <cstdint>

namespace hgs {

constexpr float kCostUnits = 2048.0f;  // a matching cost of 1, in the whole numbers that are summed

// costs: [height][width][depths], at most kCostUnits each.  grey: [height][width], whose edges may be those of depths.
// places: out, [height][width] the best place among the depths, between two of them where that fits better.
// matched: out, [height][width] the matching cost there, 0 to 1.
void semi_global(const uint16_t *costs, const float *grey, int width, int height, int depths, float *places,
                 float *matched);

}  // namespace hgs
