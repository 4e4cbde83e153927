#include "run/surface_distance.h"

#include <cmath>
#include <utility>
#include <vector>

#include "surfit/evaluation/error_statistics.h"
#include "surfit/registration/projective_association.h"

namespace surfit {

std::optional<double> MedianSurfaceDistance(const FrameLevel& source, const FrameLevel& target,
                                            const Rigid3d& target_from_source) {
  const ProjectiveAssociation association(source, target, AssociationGates(), ErrorModel());
  const PairBuffer pairs = association.Collect(target_from_source);
  std::vector<double> distances;
  for (int i = 0; i < pairs.size; ++i) {
    distances.push_back(std::abs(pairs.n(i).dot(pairs.p(i) - pairs.q(i))));
  }
  if (distances.empty()) return std::nullopt;
  return Summarize(std::move(distances)).median;
}

}  // namespace surfit
