#pragma once

#include <vector>

#include "cost_functions/batch_data.h"
#include "cost_functions/point_to_plane.h"
#include "registration/pair_buffer.h"

namespace surfit {

// The pairs of all rows as one batch, in their order.
BatchData<PointToPlane, float> MakeBatch(const std::vector<PairBuffer>& rows);

}  // namespace surfit
