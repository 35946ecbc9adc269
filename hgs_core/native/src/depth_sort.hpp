// The order in which splats are composited.
#pragma once

#include "workspace.hpp"

namespace hgs {

// Fill set.order with the visible splats by depth; equal depths stay in order of index.
void sort_by_depth(ScreenSet &set, BinningScratch &scratch, int threads);

}  // namespace hgs
