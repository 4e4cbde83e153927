#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "cost_functions/row_sums.h"
#include "registration/icp/icp_level.h"
#include "registration/icp/own_residuals.h"
#include "registration/icp/residual_rows.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Loads `count` pairs from index `first`. Further vector lanes repeat the last pair with zero
// information.
template <typename V, typename S>
void LoadPairs(const Pairs<S>& pairs, int first, int count, PairValues<V>* values) {
  const auto load = [&](const RawVector<S>& x, const RawVector<S>& y, const RawVector<S>& z,
                        V* to) {
    to[0] = V::LoadUpTo(x.data() + first, count);
    to[1] = V::LoadUpTo(y.data() + first, count);
    to[2] = V::LoadUpTo(z.data() + first, count);
  };
  load(pairs.px, pairs.py, pairs.pz, values->p);
  load(pairs.qx, pairs.qy, pairs.qz, values->q);
  load(pairs.nx, pairs.ny, pairs.nz, values->n);
  load(pairs.mx, pairs.my, pairs.mz, values->m);
  values->information = V::LoadUpTo(pairs.information.data() + first, count).UpTo(count);
}

template <typename V>
void LoadIntensities(const IntensityPairs& pairs, const Exposure& exposure, int first, int count,
                     IntensityValues<V>* values) {
  const auto load = [&](const RawVector<float>& x) { return V::LoadUpTo(x.data() + first, count); };
  values->p[0] = load(pairs.px), values->p[1] = load(pairs.py), values->p[2] = load(pairs.pz);
  values->residual =
      load(pairs.target) - (V(exposure.gain) * load(pairs.source) + V(exposure.offset));
  values->slope_u = load(pairs.slope_u), values->slope_v = load(pairs.slope_v);
}

// Selection of sums over pairs. kBesides: without products of Jacobian rows.
enum class Sums { kAll, kBesides };

// Sums of a NormalSystem per vector lane, without products of Jacobian rows.
template <typename V>
struct PairLanes {
  RowLanes<V> rows;
  V weight, inlier_count, normal_difference;
  V point[3], point_product[6];

  void Add(const PairValues<V>& pair, const typename RowLanes<V>::Weights& of_rows, int count) {
    constexpr double kInlierBound = ErrorModel::kInlierSigmas * ErrorModel::kInlierSigmas;
    weight += of_rows.weight;
    const V x = pair.m[0] - pair.n[0], y = pair.m[1] - pair.n[1], z = pair.m[2] - pair.n[2];
    normal_difference += of_rows.weight * sqrt(x * x + y * y + z * z);
    for (int i = 0, k = 0; i < 3; ++i) {
      const V weighted = of_rows.weight * pair.p[i];
      point[i] += weighted;
      for (int j = i; j < 3; ++j, ++k) point_product[k] += weighted * pair.p[j];
    }
    inlier_count += Select(of_rows.s <= V(kInlierBound), V(1.), V(0.)).UpTo(count);
  }

  void AddTo(NormalSystem* system) const {
    const V lanes[] = {weight,           normal_difference, inlier_count,     point[0],
                       point[1],         point[2],          point_product[0], point_product[1],
                       point_product[2], point_product[3],  point_product[4], point_product[5]};
    double sums[std::size(lanes)] = {};
    AddSumsOfLanes<std::size(lanes)>(lanes, sums);
    system->weight_sum += sums[0];
    system->normal_difference_sum += sums[1];
    system->inlier_count += static_cast<int>(sums[2]);
    for (int i = 0, k = 0; i < 3; ++i) {
      system->point_sum[i] += sums[3 + i];
      for (int j = i; j < 3; ++j, ++k) {
        system->point_product_sum(i, j) += sums[6 + k];
        if (i != j) system->point_product_sum(j, i) += sums[6 + k];
      }
    }
  }
};

// Normal system of the pairs [begin, end). set_rows(first, count, pair, rows) computes the Jacobian
// rows of `count` pairs from index `first`.
template <Sums kSums, int kRows, typename S, typename SetRows>
NormalSystem SystemOf(const Pairs<S>& pairs, int begin, int end, const RobustKernel& kernel,
                      double normal_ratio, const SetRows& set_rows) {
  NormalSystem system;
  RowSums sums;
  WithInstructions([&](auto instructions) {
    using V = Lanes<S, decltype(instructions)>;
    SumByLanes<V, PairLanes<V>>(
        begin, end,
        [&](int first, int count, PairLanes<V>* lanes) {
          PairValues<V> pair;
          LoadPairs(pairs, first, count, &pair);
          V rows[kRows][kRowColumns];
          set_rows(first, count, pair, rows);
          if constexpr (kSums == Sums::kAll) {
            lanes->Add(pair, lanes->rows.Add(rows, pair.information, kernel), count);
          } else {
            KernelValue<V> value;
            lanes->Add(pair, RowLanes<V>::Weigh(rows, pair.information, kernel, &value), count);
          }
        },
        [&](const PairLanes<V>& lanes) {
          if constexpr (kSums == Sums::kAll) lanes.rows.AddTo(&sums);
          lanes.AddTo(&system);
        });
  });
  SetProducts(sums, &system);
  system.pair_count = end - begin;
  system.row_count = system.pair_count * kRows;
  system.normal_ratio = normal_ratio;
  return system;
}

template <Sums kSums, typename Rows, typename S>
NormalSystem SumPairs(const Pairs<S>& pairs, int begin, int end, const RobustKernel& kernel) {
  return SystemOf<kSums, Rows::kRows>(
      pairs, begin, end, kernel, Rows::kNormalRatio,
      [](int, int, const auto& pair, auto& rows) { Rows::Evaluate(pair, rows); });
}

template <typename S>
RawVector<S> RowsOf(const OwnResidual& own, const Pairs<S>& pairs, int begin, int end) {
  RawVector<S> rows(static_cast<std::size_t>(own.row_count()) * kRowColumns * (end - begin));
  own.FillRows(pairs, begin, end, rows.data());
  return rows;
}

template <Sums kSums, int kRows, typename S>
NormalSystem SumOwnPairs(const OwnResidual& own, const Pairs<S>& pairs, int begin, int end,
                         const RobustKernel& kernel) {
  const RawVector<S> all = RowsOf(own, pairs, begin, end);
  return SystemOf<kSums, kRows>(pairs, begin, end, kernel, NormalShareOf(own),
                                [&](int first, int count, const auto&, auto& rows) {
                                  using V = std::decay_t<decltype(rows[0][0])>;
                                  const S* from = all.data() + first - begin;
                                  for (auto& row : rows) {
                                    for (V& column : row) {
                                      column = V::LoadUpTo(from, count);
                                      from += end - begin;
                                    }
                                  }
                                });
}

PhotometricSystem SumPairs(const IntensityPairs& pairs, int begin, int end,
                           const PhotometricTerm& term) {
  RowSums sums;
  WithInstructions([&](auto instructions) {
    using V = Lanes<float, decltype(instructions)>;
    SumByLanes<V, RowLanes<V>>(
        begin, end,
        [&](int first, int count, RowLanes<V>* lanes) {
          IntensityValues<V> values;
          LoadIntensities(pairs, term.exposure(), first, count, &values);
          V rows[IntensityRows::kRows][kRowColumns];
          IntensityRows::Evaluate(values, term.camera().fx, term.camera().fy, rows);
          lanes->Add(rows, V(term.information()).UpTo(count), term.kernel());
        },
        [&](const RowLanes<V>& lanes) { lanes.AddTo(&sums); });
  });
  PhotometricSystem system;
  SetProducts(sums, &system);
  system.row_count = end - begin;
  return system;
}

template <typename S>
using PairSummer = std::function<NormalSystem(const Pairs<S>&, int, int, const RobustKernel&)>;

template <Sums kSums, int kRows, typename S>
PairSummer<S> OwnPairSummer(const OwnResidual& own) {
  return [&own](const Pairs<S>& pairs, int begin, int end, const RobustKernel& kernel) {
    return SumOwnPairs<kSums, kRows>(own, pairs, begin, end, kernel);
  };
}

template <Sums kSums, typename S>
PairSummer<S> PairSummerOf(ResidualType residual) {
  if (const OwnResidual* const own = OwnResidualOf(residual)) {
    static_assert(OwnResidual::kMaxRows == 3);
    if (own->row_count() == 1) return OwnPairSummer<kSums, 1, S>(*own);
    return own->row_count() == 2 ? OwnPairSummer<kSums, 2, S>(*own)
                                 : OwnPairSummer<kSums, 3, S>(*own);
  }
  return WithRowsOf(residual,
                    [](auto rows) -> PairSummer<S> { return SumPairs<kSums, decltype(rows), S>; });
}

template <Sums kSums, typename S>
NormalSystem SumAll(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel) {
  constexpr int kPairsPerBlock = 4096;
  const PairSummer<S> sum = PairSummerOf<kSums, S>(residual);
  return ParallelSum(0, pairs.size, kPairsPerBlock, NormalSystem(),
                     [&](int begin, int end) { return sum(pairs, begin, end, kernel); });
}

}  // namespace

void SetProducts(const RowSums& sums, NormalSystem* system) {
  AddProducts(sums, &system->hessian, &system->right_side, &system->weighted_square_sum);
  system->cost = 0.5 * sums.rho;
}

void SetProducts(const RowSums& sums, PhotometricSystem* system) {
  AddProducts(sums, &system->hessian, &system->right_side, &system->square_sum);
  system->cost = 0.5 * sums.rho;
}

template <typename S>
NormalSystem Linearize(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel) {
  return SumAll<Sums::kAll>(pairs, residual, kernel);
}

template <typename S>
NormalSystem LinearizeWithoutProducts(const Pairs<S>& pairs, ResidualType residual,
                                      const RobustKernel& kernel) {
  return SumAll<Sums::kBesides>(pairs, residual, kernel);
}

NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel) {
  constexpr int kGrain = 8;
  const PairSummer<float> sum = PairSummerOf<Sums::kAll, float>(residual);
  const std::unique_ptr<const PairFinder> finder = association.At(target_from_source);
  return ParallelSum(0, association.block_count(), kGrain, NormalSystem(), [&](int begin, int end) {
    PairBuffer pairs;
    pairs.SetCapacity(association.block_capacity());
    NormalSystem system;
    for (int block = begin; block < end; ++block) {
      pairs.size = finder->Find(block, 0, &pairs);
      system += sum(pairs, 0, pairs.size, kernel);
    }
    return system;
  });
}

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

template NormalSystem Linearize(const Pairs<float>&, ResidualType, const RobustKernel&);
template NormalSystem Linearize(const Pairs<double>&, ResidualType, const RobustKernel&);
template NormalSystem LinearizeWithoutProducts(const Pairs<float>&, ResidualType,
                                               const RobustKernel&);
template NormalSystem LinearizeWithoutProducts(const Pairs<double>&, ResidualType,
                                               const RobustKernel&);

}  // namespace surfit
