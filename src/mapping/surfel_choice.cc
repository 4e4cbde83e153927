#include "mapping/surfel_choice.h"

#include <algorithm>
#include <array>
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
      for (const Offer& offer : list.offers.In(begin / kBandRows)) {
        float& distance2 = least[offer.pixel - first_pixel];
        if (offer.distance2 >= distance2) continue;
        distance2 = offer.distance2;
        own_[offer.pixel] = &list.candidates[offer.candidate];
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
  std::array<Candidate*, 9> around;
  int count = 0;
  for (int qv = std::max(0, v - 1); qv <= std::min(own_.height() - 1, v + 1); ++qv) {
    for (int qu = std::max(0, u - 1); qu <= std::min(own_.width() - 1, u + 1); ++qu) {
      around[count] = own_(qu, qv);
      count += around[count] != nullptr;
    }
  }
  Candidate* nearest = nullptr;
  float least = kFar;
  for (int begin = 0; begin < count; begin += 4) {
    // Four of them, the last again where they end: it cannot be nearer than itself.
    const auto surfel = [&](int k) { return around[std::min(begin + k, count - 1)]; };
    const MergeGate::Verdict verdict =
        gate_.Judge({point, point, point, point}, AllLanes(point.radius_m),
                    {*surfel(0), *surfel(1), *surfel(2), *surfel(3)});
    const Float4 distance2 = verdict.same ? verdict.distance2 : AllLanes(kFar);
    for (int k = 0; k < 4; ++k) {
      const bool before = nearest && surfel(k)->surfel < nearest->surfel;
      if (distance2[k] < least || (distance2[k] == least && before)) {
        nearest = surfel(k);
        least = distance2[k];
      }
    }
  }
  return nearest;
}

}  // namespace surfit
