#include "mapping/surfel_choice.h"

#include <algorithm>
#include <limits>

#include "mapping/bands.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

constexpr int kPixelsAhead = 8;

}  // namespace

void SurfelChoice::SetCandidates(int width, int height, std::vector<CandidateList>* lists) {
  own_.Resize(width, height);
  ParallelFor(0, height, kBandRows, [&](int begin, int end) {
    std::fill(own_.row(begin), own_.row(end), nullptr);
    const int first_pixel = begin * width;
    std::vector<float> least(static_cast<std::size_t>(end - begin) * width, kFar);
    for (CandidateList& list : *lists) {
      for (const int k : list.bands.In(begin / kBandRows)) {
        Candidate& candidate = list.candidates[k];
        float& distance2 = least[candidate.pixel - first_pixel];
        if (candidate.distance2 >= distance2) continue;
        distance2 = candidate.distance2;
        own_[candidate.pixel] = &candidate;
      }
    }
  });
}

bool SurfelChoice::Choose(const MeasuredPoint& point, int u, int v) const {
  // Asks for what points soon to choose will look at.
  const std::size_t soon = static_cast<std::size_t>(v + 1) * own_.width() + u + kPixelsAhead;
  if (soon < own_.size()) __builtin_prefetch(own_[soon]);
  Candidate* const own = own_(u, v);
  Candidate* const chosen = own ? own : SurfelOfNeighbours(point, u, v);
  if (!chosen) return false;
  const int du = u - chosen->pixel % own_.width(), dv = v - chosen->pixel / own_.width();
  chosen->chosen_by[3 * (dv + 1) + du + 1] = 1;
  return true;
}

Candidate* SurfelChoice::SurfelOfNeighbours(const MeasuredPoint& point, int u, int v) const {
  Candidate* nearest = nullptr;
  float least = kFar;
  for (int qv = std::max(0, v - 1); qv <= std::min(own_.height() - 1, v + 1); ++qv) {
    for (int qu = std::max(0, u - 1); qu <= std::min(own_.width() - 1, u + 1); ++qu) {
      Candidate* const candidate = own_(qu, qv);
      if (!candidate) continue;
      const float distance2 = gate_.SquaredDistance(point.patch, point.radius_m, candidate->patch);
      if (distance2 > least || distance2 == MergeGate::kNever) continue;
      // Of two that are as near the one with the smaller id.
      if (distance2 == least && candidate->surfel > nearest->surfel) continue;
      nearest = candidate;
      least = distance2;
    }
  }
  return nearest;
}

}  // namespace surfit
