#include "mapping/map/surfel_assignment.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "mapping/map/eight_records.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Points of an image row as a structure of arrays, with their assignments. Zero padding: one point
// on the left, eight points on the right.
class PointRow {
 public:
  enum Plane { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kReach2, kLeast, kState, kPlanes };

  explicit PointRow(int width) : stride_(width + 9), numbers_(kPlanes * stride_, 0.f) {}

  // Sets the points. None is assigned.
  template <typename Instructions>
  void Set(const MergeGate& gate, const MeasuredPoint* points, int width);

  // Address of the value of column u. kReach2: MergeGate::SquaredReach(), 0 without a point.
  // kLeast: squared distance to the surfel. kState: SurfelAssignment::State.
  float* At(Plane plane, int u) { return &numbers_[plane * stride_ + u + 1]; }

 private:
  const int stride_;
  std::vector<float> numbers_;
};

namespace {

constexpr int kSurfelsAhead = 8;

template <typename V>
using HalfOf = typename V::Half;

// Values of the eight pixels around column u, in the order of kStateAround. Each argument is the
// address of column u in its row.
template <typename V>
V LoadAround(const float* above, const float* own, const float* below) {
  HalfOf<V> low, high;
  std::memcpy(&low, above - 1, sizeof(low));
  std::memcpy(&high, below - 1, sizeof(high));
  low[3] = own[-1];
  high[3] = own[1];
  return V(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7));
}

template <typename V>
void StoreAround(const V& value, float* above, float* own, float* below) {
  const HalfOf<V> low = __builtin_shufflevector(value.v, value.v, 0, 1, 2, 3);
  const HalfOf<V> high = __builtin_shufflevector(value.v, value.v, 4, 5, 6, 7);
  std::memcpy(above - 1, &low, 3 * sizeof(float));
  std::memcpy(below - 1, &high, 3 * sizeof(float));
  own[-1] = low[3];
  own[1] = high[3];
}

// SurfelAssignment::State of the points above, on the left, below and on the right, if they are
// assigned to the surfel between them.
constexpr float kStateAround[8] = {8, 7, 6, 5, 2, 1, 0, 3};

// Assigns the points around a surfel to this surfel if it is nearer than their surfels before.
template <typename Instructions>
void Meet(const MergeGate& gate, const Candidate& candidate, int u, PointRow* const (&rows)[3]) {
  using V = Lanes<float, Instructions>;
  const auto load = [&](PointRow::Plane plane) {
    return LoadAround<V>(rows[0]->At(plane, u), rows[1]->At(plane, u), rows[2]->At(plane, u));
  };
  const auto store = [&](const V& value, PointRow::Plane plane) {
    StoreAround(value, rows[0]->At(plane, u), rows[1]->At(plane, u), rows[2]->At(plane, u));
  };
  const Patch& p = candidate.patch;
  const PatchOf<V> surfel = {p.x, p.y, p.z, p.nx, p.ny, p.nz};
  const PatchOf<V> points = {load(PointRow::kX),       load(PointRow::kY),
                             load(PointRow::kZ),       load(PointRow::kNormalX),
                             load(PointRow::kNormalY), load(PointRow::kNormalZ)};
  const V distance2 = gate.SquaredDistanceOnRayWithin(load(PointRow::kReach2), points, surfel);
  const V before = load(PointRow::kLeast);
  const auto nearer = distance2 < before;
  store(Select(nearer, distance2, before), PointRow::kLeast);
  store(Select(nearer, V::Load(kStateAround), load(PointRow::kState)), PointRow::kState);
  float* const least = rows[1]->At(PointRow::kLeast, u);
  if (candidate.distance2 < *least) {
    *least = candidate.distance2;
    *rows[1]->At(PointRow::kState, u) = SurfelAssignment::kOwn;
  }
}

}  // namespace

template <typename Instructions>
void PointRow::Set(const MergeGate& gate, const MeasuredPoint* points, int width) {
  static_assert(sizeof(MeasuredPoint) == 8 * sizeof(float) && offsetof(MeasuredPoint, patch) == 0 &&
                offsetof(MeasuredPoint, radius_m) == 6 * sizeof(float));
  using V = Lanes<float, Instructions>;
  constexpr int kRadius = 6;
  static constexpr float kNoRecord[8] = {};
  for (int u = 0; u < width; u += V::kCount) {
    const auto* const eight = reinterpret_cast<const float*>(points + u);
    const float* records[8];
    for (int k = 0; k < 8; ++k) records[k] = eight + 8 * k;
    for (int k = width - u; k < 8; ++k) records[k] = kNoRecord;
    V columns[8];
    EightRecords<Instructions>::Load(records, columns);
    const V radius = columns[kRadius];
    float* const to = At(kX, u);
    for (int plane = 0; plane < kRadius; ++plane) columns[plane].Store(to + plane * stride_);
    gate.SquaredReach(radius).Store(to + kReach2 * stride_);
    V(MergeGate::kNever).Store(to + kLeast * stride_);
    Select(radius > V(0.f), V(SurfelAssignment::kOpen), V(SurfelAssignment::kNoPoint))
        .Store(to + kState * stride_);
  }
}

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
  std::vector<PointRow> rows(3, PointRow(width_));
  PointRow none(width_);
  const auto row = [&](int v) { return v >= begin && v < end ? &rows[v % 3] : &none; };
  const auto load = [&](int v) {
    if (v < begin || v >= end) return;
    const MeasuredPoint* const first = &points[static_cast<std::size_t>(v) * width_];
    WithInstructions([&](auto instructions) {
      row(v)->template Set<decltype(instructions)>(gate_, first, width_);
    });
  };
  std::vector<int> columns(width_);
  load(begin);
  int count = 0;
  // Surfels of the rows next to the band also meet its points.
  for (int v = std::max(0, begin - 1); v < std::min(end + 1, height_); ++v) {
    load(v + 1);
    const Candidate* const* const own = own_.row(v);
    int surfels = 0;
    for (int u = 0; u < width_; ++u) {
      columns[surfels] = u;
      surfels += own[u] != nullptr;
    }
    PointRow* const around[] = {row(v - 1), row(v), row(v + 1)};
    WithInstructions([&](auto instructions) {
      for (int k = 0; k < surfels; ++k) {
        __builtin_prefetch(own[columns[std::min(k + kSurfelsAhead, surfels - 1)]]);
        Meet<decltype(instructions)>(gate_, *own[columns[k]], columns[k], around);
      }
    });
    for (int k = 0; k < surfels; ++k) MarkDuplicates(columns[k], v, begin, end);
    if (v > begin) count += Keep(v - 1, row(v - 1)->At(PointRow::kState, 0));
  }
  if (end == height_) count += Keep(end - 1, row(end - 1)->At(PointRow::kState, 0));
  return count;
}

// Compares the surfel of a pixel with the surfels of the four next pixels in row order. Marks the
// less confident one of two duplicates, or the second one, if it is in the rows [begin, end).
void SurfelAssignment::MarkDuplicates(int u, int v, int begin, int end) {
  Candidate* const first = own_(u, v);
  const auto compare = [&](int second_u, int second_v) {
    Candidate* const second = own_(second_u, second_v);
    if (!second) return;
    const bool is_first_worse = second->confidence > first->confidence;
    const int row = is_first_worse ? v : second_v;
    if (row < begin || row >= end) return;
    Candidate* const worse = is_first_worse ? first : second;
    const Candidate* const better = is_first_worse ? second : first;
    const float apart2 = gate_.SquaredDistanceOfDuplicates(worse->patch, worse->radius_m,
                                                           better->patch, better->radius_m);
    if (apart2 != MergeGate::kNever) worse->is_duplicate = true;
  };
  const bool has_left = u > 0, has_right = u + 1 < width_;
  if (has_right) compare(u + 1, v);
  if (v + 1 == height_) return;
  if (has_left) compare(u - 1, v + 1);
  compare(u, v + 1);
  if (has_right) compare(u + 1, v + 1);
}

int SurfelAssignment::Keep(int v, const float* state_of_column) {
  auto& open = open_[v / kBandRows];
  State* const states = states_.row(v + 1) + 1;
  const int width = width_;
  const int count = WithInstructions([&](auto) {
    int points = 0;
    for (int u = 0; u < width; ++u) {
      const int state = static_cast<int>(state_of_column[u]);
      states[u] = static_cast<State>(state);
      points += state != kNoPoint;
    }
    return points;
  });
  for (int u = 0; u < width; ++u) {
    if (states[u] == kOpen) open[2 * (v % 2) + u % 2].push_back(v * width + u);
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
