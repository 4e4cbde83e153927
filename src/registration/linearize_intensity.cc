#include "registration/linearize_intensity.h"

#include <algorithm>

#include "cost_functions/robust_kernel.h"
#include "registration/add_products.h"
#include "registration/photometric_rows.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

template <typename V>
struct LaneSums {
  RowProducts<V> products;
  V rho;
};

// Lanes beyond the first `count` repeat the last pair, without weight.
template <typename V>
void AddLanes(const IntensityPairs& pairs, int first, int count, const PhotometricTerm& term,
              LaneSums<V>* sums) {
  const auto load = [&](const RawVector<float>& x) { return V::LoadUpTo(x.data() + first, count); };
  const Exposure& exposure = term.exposure();
  const IntensityValues<V> values = {
      {load(pairs.px), load(pairs.py), load(pairs.pz)},
      load(pairs.target) - (V(exposure.gain) * load(pairs.source) + V(exposure.offset)),
      load(pairs.slope_u),
      load(pairs.slope_v)};
  V row[kRowColumns];
  SetPhotometricRow(values, term.camera().fx, term.camera().fy, row);
  const V information = V(term.information()).UpTo(count);
  const KernelValue<V> value =
      EvaluateKernel(term.kernel(), values.residual * values.residual * information);
  sums->products.Add(row, information * value.slope);
  sums->rho += value.rho;
}

template <typename V>
void SumLanes(const IntensityPairs& pairs, int begin, int end, const PhotometricTerm& term,
              PhotometricSystem* system) {
  constexpr int kFlush = 8 * V::kCount;
  for (int first = begin; first < end; first += kFlush) {
    LaneSums<V> sums;
    const int last = std::min(end, first + kFlush);
    for (int i = first; i < last; i += V::kCount) AddLanes(pairs, i, last - i, term, &sums);
    AddProducts(sums.products, &system->hessian, &system->right_side, &system->square_sum);
    system->cost += 0.5 * SumOfLanes(sums.rho);
  }
}

PhotometricSystem SumPairs(const IntensityPairs& pairs, int begin, int end,
                           const PhotometricTerm& term) {
  PhotometricSystem system;
  WithInstructions([&](auto instructions) {
    SumLanes<Lanes<float, decltype(instructions)>>(pairs, begin, end, term, &system);
  });
  system.row_count = end - begin;
  return system;
}

}  // namespace

PhotometricSystem Linearize(const IntensityPairs& pairs, const PhotometricTerm& term) {
  constexpr int kPairsPerBlock = 4096;
  return ParallelSum(0, pairs.size, kPairsPerBlock, PhotometricSystem(),
                     [&](int begin, int end) { return SumPairs(pairs, begin, end, term); });
}

PhotometricSystem Linearize(const PhotometricTerm& term, const Rigid3d& target_from_source) {
  return ParallelSum(0, term.block_count(), 1, PhotometricSystem(), [&](int block, int) {
    IntensityPairs pairs;
    term.Find(block, target_from_source, &pairs);
    return SumPairs(pairs, 0, pairs.size, term);
  });
}

}  // namespace surfit
