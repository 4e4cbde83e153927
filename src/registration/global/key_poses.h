#pragma once

#include <vector>

#include "registration/global/cloud_pair.h"

namespace surfit {

// Tentative pose with its CloudPair::KeyScore().
struct ScoredKeyPose {
  Rigid3d target_from_source;
  double score = 0;
};

// Finds poses by matches of local shapes, and registers the key points from the best ones. Poses
// with too many free-space violations are dropped. The best pose is first. `viewpoints`: decide the
// signs of the normals.
std::vector<ScoredKeyPose> FindKeyPoses(const CloudPair& pair,
                                        const CloudPair::ViewpointPair& viewpoints);

}  // namespace surfit
