#include "mapping/candidate_finder.h"

#include <glog/logging.h>

#include <algorithm>

#include "mapping/bands.h"

namespace surfit {

// Four surfels in the image.
struct CandidateFinder::Seen {
  int begin, end;    // in the map
  Int4 inside;       // mask: those in the image
  Int4 pixels;       // 0 for the others
  Vector4 position;  // in the camera frame
};

struct CandidateFinder::Found {
  int size = 0;
  Candidate candidates[kCapacity];
  Offer offers[kCapacity];
};

// Surfels that follow each other in the map meet points all over the image. Some time passes
// between asking for these points and looking at them, so that they are in the cache by then.
void CandidateFinder::Find(int begin, int end, std::vector<std::uint8_t>* remove,
                           CandidateList* list) const {
  CHECK_LE(end - begin, kCapacity);
  constexpr int kAhead = 32;
  Seen seen[kAhead];
  Found found;
  for (int i = begin; i < end;) {
    int count = 0;
    for (const int stop = std::min(end, i + 4 * kAhead); i < stop; i += 4) {
      count += Project(i, std::min(end, i + 4), &seen[count]);
    }
    for (int k = 0; k < count; ++k) Judge(seen[k], remove, &found);
  }
  list->candidates = {found.candidates, found.candidates + found.size};
  list->offers.Assign(
      found.offers, found.size, BandCount(camera_.height),
      [&](int k, const auto& f) { f(found.offers[k].pixel / (camera_.width * kBandRows)); });
}

// False if none of the surfels is in the image.
bool CandidateFinder::Project(int begin, int end, Seen* seen) const {
  const FourCentres centres = projector_.Centres(begin, end);
  const Float4 u = centres.u + 0.5f, v = centres.v + 0.5f;
  const Int4 inside = centres.in_front & (u >= 0.f) & (v >= 0.f) &
                      (u < static_cast<float>(camera_.width)) &
                      (v < static_cast<float>(camera_.height));
  if (!Any(inside)) return false;
  const Int4 column = ToInt(inside ? u : Float4{}), row = ToInt(inside ? v : Float4{});
  *seen = {begin, end, inside, row * camera_.width + column, centres.position};
  for (int k = 0; k < 4; ++k) {
    __builtin_prefetch(&points_[seen->pixels[k]]);
    __builtin_prefetch(&free_depth_m_[seen->pixels[k]]);
  }
  return true;
}

void CandidateFinder::Judge(const Seen& seen, std::vector<std::uint8_t>* remove,
                            Found* found) const {
  const Int4 at = seen.pixels;
  const MeasuredPoint &a = points_[at[0]], &b = points_[at[1]], &c = points_[at[2]],
                      &d = points_[at[3]];
  const Float4 radius_m = {a.radius_m, b.radius_m, c.radius_m, d.radius_m};
  const Float4 free_depth_m = {free_depth_m_[at[0]], free_depth_m_[at[1]], free_depth_m_[at[2]],
                               free_depth_m_[at[3]]};
  const FourPatches surfels(seen.position, projector_.Normals(seen.begin, seen.end));
  const MergeGate::Verdict verdict = gate_.Judge({a, b, c, d}, radius_m, surfels);
  const Int4 through = seen.inside & (seen.position.z < free_depth_m);
  const Int4 same = seen.inside & verdict.same;
  if (!Any(through | same)) return;
  for (int k = 0; k < 4; ++k) {
    const int i = seen.begin + k;
    if (through[k]) (*remove)[i] = 1;
    if (!same[k] || (*remove)[i]) continue;
    found->offers[found->size] = {verdict.distance2[k], at[k], found->size};
    Candidate& candidate = found->candidates[found->size++];
    candidate.position = {surfels.position.x[k], surfels.position.y[k], surfels.position.z[k]};
    candidate.normal = {surfels.normal.x[k], surfels.normal.y[k], surfels.normal.z[k]};
    candidate.surfel = i;
    candidate.pixel = at[k];
    candidate.chosen_by.fill(0);
  }
}

}  // namespace surfit
