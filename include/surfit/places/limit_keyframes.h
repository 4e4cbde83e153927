#pragma once

#include <cstddef>
#include <vector>

#include "surfit/places/place_index.h"

namespace surfit {

// Bounds the memory of keyframes' views: while they take more than `max_bytes`, the two whose
// cameras are most alike are found, and the view of the older is given up; the keyframe itself
// stays, with its pose. Returns the positions of those given up, in that order, which are also
// taken out of the index.
std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index);

}  // namespace surfit
