#pragma once

#include "registration/global/cloud_pair.h"

namespace surfit {

// Returns whether the surfaces determine the pose of result->icp. Directions with a small standard
// deviation are certain. For the other directions, ICP runs from displaced poses, and must return.
// Sets sigma_m, and `degenerate_directions` of ICP to the directions that are not determined.
bool IsCertain(const CloudPair& pair, CloudRegistration* result);

}  // namespace surfit
