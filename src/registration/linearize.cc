#include "registration/linearize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "cost_functions/robust_kernel.h"
#include "registration/add_products.h"
#include "registration/residual_rows.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Lanes beyond the first `count` repeat the last pair, without information.
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

// s = |r|^2 / sigma^2 of the rows of a pair.
template <int kRows, typename V>
V SquaredResidual(const V rows[][kRowColumns], const V& information) {
  V sum(0.);
  for (int k = 0; k < kRows; ++k) sum += rows[k][6] * rows[k][6];
  return sum * information;
}

// Sums of what makes a NormalSystem, one a lane.
template <typename V>
struct LaneSums {
  RowProducts<V> products;
  V rho, weight, inlier_count, normal_difference;
  V point[3], point_product[6];
};

template <typename Rows, typename V, typename S>
void AddLanes(const Pairs<S>& pairs, int first, int count, const RobustKernel& kernel,
              LaneSums<V>* sums) {
  constexpr double kInlierBound = ErrorModel::kInlierSigmas * ErrorModel::kInlierSigmas;
  PairValues<V> pair;
  LoadPairs(pairs, first, count, &pair);
  V rows[Rows::kRows][kRowColumns];
  Rows::Evaluate(pair, rows);
  const V s = SquaredResidual<Rows::kRows>(rows, pair.information);
  const KernelValue<V> value = EvaluateKernel(kernel, s);
  const V weight = pair.information * value.slope;
  for (int k = 0; k < Rows::kRows; ++k) sums->products.Add(rows[k], weight);
  sums->weight += weight;
  const V x = pair.m[0] - pair.n[0], y = pair.m[1] - pair.n[1], z = pair.m[2] - pair.n[2];
  sums->normal_difference += weight * sqrt(x * x + y * y + z * z);
  for (int i = 0, k = 0; i < 3; ++i) {
    const V weighted = weight * pair.p[i];
    sums->point[i] += weighted;
    for (int j = i; j < 3; ++j, ++k) sums->point_product[k] += weighted * pair.p[j];
  }
  sums->rho += value.rho;
  sums->inlier_count += Select(s <= V(kInlierBound), V(1.), V(0.)).UpTo(count);
}

template <typename V>
void Flush(const LaneSums<V>& sums, NormalSystem* system) {
  AddProducts(sums.products, &system->hessian, &system->right_side, &system->weighted_square_sum);
  system->cost += 0.5 * SumOfLanes(sums.rho);
  system->weight_sum += SumOfLanes(sums.weight);
  system->normal_difference_sum += SumOfLanes(sums.normal_difference);
  for (int i = 0, k = 0; i < 3; ++i) {
    system->point_sum[i] += SumOfLanes(sums.point[i]);
    for (int j = i; j < 3; ++j, ++k) {
      const double sum = SumOfLanes(sums.point_product[k]);
      system->point_product_sum(i, j) += sum;
      if (i != j) system->point_product_sum(j, i) += sum;
    }
  }
  system->inlier_count += static_cast<int>(SumOfLanes(sums.inlier_count));
}

// The system of the pairs [begin, end), lanes summed over at most 8 values each.
template <typename Rows, typename V, typename S>
void SumLanes(const Pairs<S>& pairs, int begin, int end, const RobustKernel& kernel,
              NormalSystem* system) {
  constexpr int kFlush = 8 * V::kCount;
  for (int first = begin; first < end; first += kFlush) {
    LaneSums<V> sums;
    const int last = std::min(end, first + kFlush);
    for (int i = first; i < last; i += V::kCount) {
      AddLanes<Rows>(pairs, i, last - i, kernel, &sums);
    }
    Flush(sums, system);
  }
}

template <typename Rows, typename S>
NormalSystem SumPairs(const Pairs<S>& pairs, int begin, int end, const RobustKernel& kernel) {
  NormalSystem system;
  WithInstructions([&](auto instructions) {
    SumLanes<Rows, Lanes<S, decltype(instructions)>>(pairs, begin, end, kernel, &system);
  });
  system.pair_count = end - begin;
  system.row_count = system.pair_count * Rows::kRows;
  system.normal_share = Rows::kNormalShare;
  return system;
}

template <typename S>
using PairSummer = NormalSystem (*)(const Pairs<S>&, int, int, const RobustKernel&);

template <typename S>
PairSummer<S> PairSummerOf(ResidualType residual) {
  return WithRowsOf(residual,
                    [](auto rows) -> PairSummer<S> { return SumPairs<decltype(rows), S>; });
}

// The median of |r| / sigma; 0 without pairs.
template <typename Rows, typename S>
double MedianResidual(const Pairs<S>& pairs) {
  if (pairs.size == 0) return 0;
  std::vector<S> residuals(pairs.size);
  ParallelFor(0, pairs.size, 4096, [&](int begin, int end) {
    using V = Lanes<S>;
    for (int i = begin; i < end; i += V::kCount) {
      const int count = std::min(end - i, V::kCount);
      PairValues<V> pair;
      LoadPairs(pairs, i, count, &pair);
      V rows[Rows::kRows][kRowColumns];
      Rows::Evaluate(pair, rows);
      const V s = SquaredResidual<Rows::kRows>(rows, pair.information);
      for (int k = 0; k < count; ++k) residuals[i + k] = s[k];
    }
  });
  const auto middle = residuals.begin() + pairs.size / 2;
  std::nth_element(residuals.begin(), middle, residuals.end());
  return std::sqrt(static_cast<double>(*middle));
}

}  // namespace

template <typename S>
NormalSystem Linearize(const Pairs<S>& pairs, ResidualType residual, const RobustKernel& kernel) {
  constexpr int kPairsPerBlock = 4096;
  const PairSummer<S> sum = PairSummerOf<S>(residual);
  return ParallelSum(0, pairs.size, kPairsPerBlock, NormalSystem(),
                     [&](int begin, int end) { return sum(pairs, begin, end, kernel); });
}

NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel) {
  constexpr int kGrain = 8;
  const PairSummer<float> sum = PairSummerOf<float>(residual);
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

template <typename S>
RobustKernel KernelFor(const Pairs<S>& pairs, ResidualType residual,
                       const ErrorModel& error_model) {
  RobustKernel kernel = error_model.kernel;
  if (!error_model.estimate_scale || kernel.type == RobustKernelType::kNone) return kernel;
  const double scale = WithRowsOf(residual, [&](auto rows) {
    using Rows = decltype(rows);
    const double of_normal_errors = Rows::kRows == 1 ? 0.6745 : 1.5382;
    return MedianResidual<Rows>(pairs) / of_normal_errors;
  });
  constexpr double kSmallest = 1e-3;  // residuals that vanish leave no scale
  kernel.width *= std::max(scale, kSmallest);
  return kernel;
}

template NormalSystem Linearize(const Pairs<float>&, ResidualType, const RobustKernel&);
template NormalSystem Linearize(const Pairs<double>&, ResidualType, const RobustKernel&);
template RobustKernel KernelFor(const Pairs<float>&, ResidualType, const ErrorModel&);
template RobustKernel KernelFor(const Pairs<double>&, ResidualType, const ErrorModel&);

}  // namespace surfit
