#include "mapping/map/surfel_assignment.h"

#include <algorithm>
#include <cstddef>

#include "mapping/map/eight_records.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Patches of an image row as a structure of arrays. Zero padding: one patch on the left, eight
// patches on the right.
class PatchRow {
 public:
  explicit PatchRow(int width) : stride_(width + 9), numbers_(kNumbers * stride_, 0.f) {}

  // Sets the patches of columns u to u + 7. A record has the patch (6 floats), radius and
  // confidence. The first `count` floats are stored. Records after the end of the row must be zero.
  template <typename Instructions>
  void SetEight(int u, const float* const (&records)[8], int count) {
    Lanes<float, Instructions> columns[kNumbers];
    EightRecords<Instructions>::Load(records, columns);
    for (int i = 0; i < count; ++i) columns[i].Store(&numbers_[i * stride_ + u + 1]);
  }

  template <typename Numbers>
  PatchOf<Numbers> Patches(int u) const {
    return {Load<Numbers>(0, u), Load<Numbers>(1, u), Load<Numbers>(2, u),
            Load<Numbers>(3, u), Load<Numbers>(4, u), Load<Numbers>(5, u)};
  }
  template <typename Numbers>
  Numbers Radii(int u) const {
    return Load<Numbers>(6, u);
  }
  template <typename Numbers>
  Numbers Confidences(int u) const {
    return Load<Numbers>(7, u);
  }

 private:
  template <typename Numbers>
  Numbers Load(int i, int u) const {
    return Numbers::Load(&numbers_[i * stride_ + u + 1]);
  }

  static constexpr int kNumbers = 8;

  const int stride_;
  std::vector<float> numbers_;
};

// Results of Meet() for an image row. Padding allows vector stores after the last pixel.
struct RowOutcome {
  explicit RowOutcome(int width) : state(width + 7), superfluous(width + 7) {}

  std::vector<std::int32_t> state;  // values of SurfelAssignment::State
  std::vector<std::int32_t> superfluous;
};

namespace {

constexpr int kPixelsAhead = 16;

constexpr float kNoRecord[8] = {};

void LoadPoints(const MeasuredPoint* points, int width, PatchRow* row) {
  static_assert(offsetof(MeasuredPoint, patch) == 0 &&
                offsetof(MeasuredPoint, radius_m) == 6 * sizeof(float));
  WithInstructions([&](auto instructions) {
    for (int u = 0; u < width; u += 8) {
      const float* records[8];
      for (int k = 0; k < 8; ++k) {
        records[k] = u + k < width ? reinterpret_cast<const float*>(&points[u + k]) : kNoRecord;
      }
      row->SetEight<decltype(instructions)>(u, records, 7);
    }
  });
}

void LoadSurfels(Candidate* const* own, int width, PatchRow* row) {
  static_assert(offsetof(Candidate, patch) == 0 &&
                offsetof(Candidate, radius_m) == 6 * sizeof(float) &&
                offsetof(Candidate, confidence) == 7 * sizeof(float));
  WithInstructions([&](auto instructions) {
    for (int u = 0; u < width; u += 8) {
      const float* records[8];
      for (int k = 0; k < 8; ++k) {
        if (u + k + kPixelsAhead < width) __builtin_prefetch(own[u + k + kPixelsAhead]);
        const Candidate* const candidate = u + k < width ? own[u + k] : nullptr;
        records[k] = candidate ? reinterpret_cast<const float*>(candidate) : kNoRecord;
      }
      row->SetEight<decltype(instructions)>(u, records, 8);
    }
  });
}

// Assigns each point of a pixel row to the nearest surfel of the 3 x 3 neighbourhood. If distances
// are equal, the first surfel in row order wins. Also marks surfels of the middle row that
// duplicate a neighbour of higher confidence.
template <typename Instructions>
void Meet(const MergeGate& gate, const PatchRow& points, const PatchRow* const rows[3], int width,
          RowOutcome* outcome) {
  using Numbers = Lanes<float, Instructions>;
  const Numbers never = MergeGate::kNever, zero = 0.f, one = 1.f;
  for (int u = 0; u < width; u += Numbers::kCount) {
    const PatchOf<Numbers> point = points.Patches<Numbers>(u);
    const PatchOf<Numbers> own = rows[1]->Patches<Numbers>(u);
    const Numbers point_radius = points.Radii<Numbers>(u), radius = rows[1]->Radii<Numbers>(u);
    const Numbers confidence = rows[1]->Confidences<Numbers>(u);
    Numbers least = never, superfluous = zero;
    const auto has_point = point_radius > zero;
    Numbers state =
        Select(has_point, Numbers(SurfelAssignment::kOpen), Numbers(SurfelAssignment::kNoPoint));
    for (int k = 0; k < 9 && Numbers::Any(has_point); ++k) {
      const PatchRow& row = *rows[k / 3];
      const int beside = u + k % 3 - 1;
      const PatchOf<Numbers> other = row.Patches<Numbers>(beside);
      const Numbers distance2 = gate.SquaredDistanceOnRay(point, point_radius, other);
      const auto nearer = distance2 < least;
      least = Select(nearer, distance2, least);
      state = Select(nearer, Numbers(k), state);
      if (k == SurfelAssignment::kOwn) continue;
      const Numbers gain = row.Confidences<Numbers>(beside) - confidence;
      const auto better = k < SurfelAssignment::kOwn ? gain >= zero : gain > zero;
      const Numbers apart2 =
          gate.SquaredDistanceOfDuplicates(own, radius, other, row.Radii<Numbers>(beside));
      superfluous = Select(Numbers::Both(better, apart2 < never), one, superfluous);
    }
    state.StoreTruncated(&outcome->state[u]);
    superfluous.StoreTruncated(&outcome->superfluous[u]);
  }
}

}  // namespace

void SurfelAssignment::SetCandidates(int width, int height, std::vector<CandidateList>* lists) {
  width_ = width;
  height_ = height;
  own_.Resize(width, height);
  ParallelFor(0, BandCount(height), 1, [&](int band, int) { SetCandidates(band, lists); });
}

void SurfelAssignment::SetCandidates(int band, std::vector<CandidateList>* lists) {
  const int begin = band * kBandRows, end = std::min(begin + kBandRows, height_);
  std::fill(own_.row(begin), own_.row(end), nullptr);
  const auto for_each = [&](const auto& f) {
    for (CandidateList& list : *lists) {
      for (const int k : list.bands.In(band)) f(&list.candidates[k]);
    }
  };
  for_each([&](Candidate* candidate) {
    Candidate*& own = own_[candidate->pixel];
    if (!own || candidate->distance2 < own->distance2) own = candidate;
  });
  for_each([&](Candidate* candidate) {
    Candidate* const own = own_[candidate->pixel];
    if (own == candidate) return;
    const float apart2 = gate_.SquaredDistanceOfDuplicates(candidate->patch, candidate->radius_m,
                                                           own->patch, own->radius_m);
    if (apart2 == MergeGate::kNever) return;
    Candidate* const worse = candidate->confidence > own->confidence ? own : candidate;
    worse->is_duplicate = true;
  });
}

void SurfelAssignment::AssignmentsOfRow(int v, std::uint16_t* masks) const {
  const State* const above = states_.row(v);
  const int width = width_, stride = width_ + 2;
  WithInstructions([&](auto) {
    std::fill(masks, masks + width, std::uint16_t{0});
    for (int k = 0; k < 9; ++k) {
      const State* const beside = above + k / 3 * stride + k % 3;
      const auto choosing = static_cast<State>(8 - k);
      const auto bit = static_cast<std::uint16_t>(1 << k);
      for (int u = 0; u < width; ++u) masks[u] |= beside[u] == choosing ? bit : std::uint16_t{0};
    }
  });
}

int SurfelAssignment::AssignAll(const std::vector<MeasuredPoint>& points) {
  if (states_.width() != width_ + 2 || states_.height() != height_ + 2) {
    states_ = Image<State>(width_ + 2, height_ + 2, kNoPoint);
  }
  open_.resize(BandCount(height_));
  return ParallelSum(0, height_, kBandRows, 0,
                     [&](int begin, int end) { return ChooseBand(points, begin, end); });
}

int SurfelAssignment::ChooseBand(const std::vector<MeasuredPoint>& points, int begin, int end) {
  for (std::vector<int>& phase : open_[begin / kBandRows]) phase.clear();
  PatchRow of_points(width_);
  std::vector<PatchRow> surfels(3, PatchRow(width_));
  const PatchRow none(width_);
  RowOutcome outcome(width_);
  if (begin > 0) LoadSurfels(own_.row(begin - 1), width_, &surfels[(begin - 1) % 3]);
  LoadSurfels(own_.row(begin), width_, &surfels[begin % 3]);
  int count = 0;
  for (int v = begin; v < end; ++v) {
    if (v + 1 < height_) LoadSurfels(own_.row(v + 1), width_, &surfels[(v + 1) % 3]);
    LoadPoints(&points[static_cast<std::size_t>(v) * width_], width_, &of_points);
    const PatchRow* const rows[] = {v > 0 ? &surfels[(v - 1) % 3] : &none, &surfels[v % 3],
                                    v + 1 < height_ ? &surfels[(v + 1) % 3] : &none};
    WithInstructions([&](auto instructions) {
      Meet<decltype(instructions)>(gate_, of_points, rows, width_, &outcome);
    });
    count += Keep(v, outcome);
  }
  return count;
}

int SurfelAssignment::Keep(int v, const RowOutcome& outcome) {
  auto& open = open_[v / kBandRows];
  State* states = states_.row(v + 1) + 1;
  int count = 0;
  for (int u = 0; u < width_; ++u) {
    states[u] = static_cast<State>(outcome.state[u]);
    count += states[u] != kNoPoint;
    if (states[u] == kOpen) open[2 * (v % 2) + u % 2].push_back(v * width_ + u);
    if (outcome.superfluous[u]) own_(u, v)->is_duplicate = true;
  }
  return count;
}

const std::vector<std::vector<int>>& SurfelAssignment::SelectNew(
    const std::vector<MeasuredPoint>& points) {
  const int bands = BandCount(height_);
  new_.resize(bands);
  for (std::vector<int>& of_band : new_) of_band.clear();
  // Pixels of the same phase are never neighbours, so bands run in parallel.
  for (const int phase : {0, 3, 1, 2}) {
    ParallelFor(0, bands, 1, [&](int band, int) { SelectNewOfPhase(points, band, phase); });
  }
  for (std::vector<int>& of_band : new_) std::sort(of_band.begin(), of_band.end());
  return new_;
}

void SurfelAssignment::SelectNewOfPhase(const std::vector<MeasuredPoint>& points, int band,
                                        int phase) {
  for (const int pixel : open_[band][phase]) {
    if (IsCovered(points, pixel)) continue;
    states_[PaddedIndex(pixel)] = kNew;
    new_[band].push_back(pixel);
  }
}

bool SurfelAssignment::IsCovered(const std::vector<MeasuredPoint>& points, int pixel) const {
  const State* middle = &states_[PaddedIndex(pixel)];
  for (int k = 0; k < 9; ++k) {
    const int du = k % 3 - 1, dv = k / 3 - 1;
    if (middle[dv * (width_ + 2) + du] != kNew) continue;
    const float distance2 = gate_.SquaredDistanceOnRay(points[pixel].patch, points[pixel].radius_m,
                                                       points[pixel + dv * width_ + du].patch);
    if (distance2 != MergeGate::kNever) return true;
  }
  return false;
}

}  // namespace surfit
