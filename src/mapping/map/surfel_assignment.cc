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

  // Address of the value of column 0. The next plane is stride() values further. kReach2:
  // MergeGate::SquaredReach(), 0 without a point. kLeast: squared distance to the surfel. kState:
  // SurfelAssignment::State.
  float* Values(Plane plane) { return &numbers_[plane * stride_ + 1]; }
  std::ptrdiff_t stride() const { return stride_; }

 private:
  // Sets eight points. `to`: value of the first one in plane kX.
  template <typename Instructions>
  void SetEight(const MergeGate& gate, const float* const (&records)[8], float* to) const;

  const std::ptrdiff_t stride_;
  std::vector<float> numbers_;
};

namespace {

constexpr int kSurfelsAhead = 8;

// Addresses of one value of three rows in the same column.
struct Around {
  float *above, *own, *below;

  Around operator+(std::ptrdiff_t offset) const {
    return {above + offset, own + offset, below + offset};
  }
};

// Values of the eight pixels around the column, in the order of kStateAround.
template <typename V>
V LoadAround(const Around& from) {
  typename V::Half low, high;
  std::memcpy(&low, from.above - 1, sizeof(low));
  std::memcpy(&high, from.below - 1, sizeof(high));
  low[3] = from.own[-1];
  high[3] = from.own[1];
  return V(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7));
}

template <typename V>
void StoreAround(const V& value, const Around& to) {
  const typename V::Half low = __builtin_shufflevector(value.v, value.v, 0, 1, 2, 3);
  const typename V::Half high = __builtin_shufflevector(value.v, value.v, 4, 5, 6, 7);
  // One copy of three values would go through the stack.
  std::memcpy(to.above - 1, &low, 2 * sizeof(float));
  to.above[1] = low[2];
  to.own[-1] = low[3];
  std::memcpy(to.below - 1, &high, 2 * sizeof(float));
  to.below[1] = high[2];
  to.own[1] = high[3];
}

// SurfelAssignment::State of the points above, on the left, below and on the right, if they are
// assigned to the surfel between them.
constexpr float kStateAround[8] = {8, 7, 6, 5, 2, 1, 0, 3};

// The same value in all lanes. The conversion of a number to Lanes also adds zero.
template <typename V>
V Broadcast(float x) {
  const typename V::Vector all = {x, x, x, x, x, x, x, x};
  return V(all);
}

// Assigns the points around a surfel to this surfel if it is nearer than their surfels before.
// `at`: plane kX in the column of the surfel. `stride`: distance of two planes.
template <typename Instructions>
void Meet(const MergeGate& gate, const Candidate& candidate, const Around& at,
          std::ptrdiff_t stride) {
  using V = Lanes<float, Instructions>;
  const auto load = [&](PointRow::Plane plane) { return LoadAround<V>(at + plane * stride); };
  const Patch& p = candidate.patch;
  const PatchOf<V> surfel = {Broadcast<V>(p.x),  Broadcast<V>(p.y),  Broadcast<V>(p.z),
                             Broadcast<V>(p.nx), Broadcast<V>(p.ny), Broadcast<V>(p.nz)};
  const PatchOf<V> points = {load(PointRow::kX),       load(PointRow::kY),
                             load(PointRow::kZ),       load(PointRow::kNormalX),
                             load(PointRow::kNormalY), load(PointRow::kNormalZ)};
  const V distance2 = gate.SquaredDistanceOnRayWithin(load(PointRow::kReach2), points, surfel);
  const Around least = at + PointRow::kLeast * stride, state = at + PointRow::kState * stride;
  const V before = LoadAround<V>(least);
  const auto nearer = distance2 < before;
  StoreAround(Select(nearer, distance2, before), least);
  StoreAround(Select(nearer, V::Load(kStateAround), LoadAround<V>(state)), state);
  if (candidate.distance2 < *least.own) {
    *least.own = candidate.distance2;
    *state.own = SurfelAssignment::kOwn;
  }
}

}  // namespace

template <typename Instructions>
void PointRow::Set(const MergeGate& gate, const MeasuredPoint* points, int width) {
  static_assert(sizeof(MeasuredPoint) == 8 * sizeof(float) && offsetof(MeasuredPoint, patch) == 0 &&
                offsetof(MeasuredPoint, radius_m) == 6 * sizeof(float));
  static constexpr float kNoRecord[8] = {};
  const auto* const first = reinterpret_cast<const float*>(points);
  int u = 0;
  for (; u + 8 <= width; u += 8) {
    const float* const r = first + 8 * u;
    SetEight<Instructions>(gate, {r, r + 8, r + 16, r + 24, r + 32, r + 40, r + 48, r + 56},
                           Values(kX) + u);
  }
  if (u == width) return;
  const float* records[8];
  for (int k = 0; k < 8; ++k) records[k] = u + k < width ? first + 8 * (u + k) : kNoRecord;
  SetEight<Instructions>(gate, records, Values(kX) + u);
}

template <typename Instructions>
void PointRow::SetEight(const MergeGate& gate, const float* const (&records)[8], float* to) const {
  using V = Lanes<float, Instructions>;
  V columns[8];
  EightRecords<Instructions>::Load(records, columns);
  const V radius = columns[6];
  columns[0].Store(to + kX * stride_);
  columns[1].Store(to + kY * stride_);
  columns[2].Store(to + kZ * stride_);
  columns[3].Store(to + kNormalX * stride_);
  columns[4].Store(to + kNormalY * stride_);
  columns[5].Store(to + kNormalZ * stride_);
  gate.SquaredReach(radius).Store(to + kReach2 * stride_);
  V(MergeGate::kNever).Store(to + kLeast * stride_);
  Select(radius > V(0.f), V(SurfelAssignment::kOpen), V(SurfelAssignment::kNoPoint))
      .Store(to + kState * stride_);
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
    const Around around = {row(v - 1)->Values(PointRow::kX), row(v)->Values(PointRow::kX),
                           row(v + 1)->Values(PointRow::kX)};
    WithInstructions([&](auto instructions) {
      const MergeGate gate = gate_;  // a copy, so that no store changes it
      for (int k = 0; k < surfels; ++k) {
        __builtin_prefetch(own[columns[std::min(k + kSurfelsAhead, surfels - 1)]]);
        Meet<decltype(instructions)>(gate, *own[columns[k]], around + columns[k], none.stride());
      }
    });
    for (int k = 0; k < surfels; ++k) MarkDuplicates(columns[k], v, begin, end);
    if (v > begin) count += Keep(v - 1, row(v - 1)->Values(PointRow::kState));
  }
  if (end == height_) count += Keep(end - 1, row(end - 1)->Values(PointRow::kState));
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
