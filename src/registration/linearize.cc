#include "registration/linearize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "cost_functions/robust_kernel.h"
#include "registration/residual_rows.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Lanes beyond the first `count` repeat the last pair, without information.
template <typename S>
PairValues<Lanes<S>> LoadPairs(const Pairs<S>& pairs, int first, int count) {
  const auto load = [&](const std::vector<S>& array) {
    return Lanes<S>::LoadUpTo(array.data() + first, count);
  };
  return {{load(pairs.px), load(pairs.py), load(pairs.pz)},
          {load(pairs.qx), load(pairs.qy), load(pairs.qz)},
          {load(pairs.nx), load(pairs.ny), load(pairs.nz)},
          {load(pairs.mx), load(pairs.my), load(pairs.mz)},
          load(pairs.information).UpTo(count)};
}

// s = |r|^2 / sigma^2 of the rows of a pair.
template <int kRows, typename V>
V SquaredResidual(const V rows[][kRowColumns], V information) {
  V sum(0.);
  for (int k = 0; k < kRows; ++k) sum += rows[k][6] * rows[k][6];
  return sum * information;
}

// Sums of what makes a NormalSystem, one a lane.
template <typename V>
struct LaneSums {
  RowProducts<V> products;
  V rho, weight, point_square, inlier_count;
};

template <typename Rows, RobustKernelType kKernel, typename S>
void AddLanes(const Pairs<S>& pairs, int first, int count, double kernel_width,
              LaneSums<Lanes<S>>* sums) {
  using V = Lanes<S>;
  constexpr double kInlierBound = ErrorModel::kInlierSigmas * ErrorModel::kInlierSigmas;
  const PairValues<V> pair = LoadPairs(pairs, first, count);
  V rows[Rows::kRows][kRowColumns];
  Rows::Evaluate(pair, rows);
  const V s = SquaredResidual<Rows::kRows>(rows, pair.information);
  const KernelValue<V> kernel = EvaluateKernel<kKernel>(s, kernel_width);
  const V weight = pair.information * kernel.slope;
  for (int k = 0; k < Rows::kRows; ++k) sums->products.Add(rows[k], weight);
  sums->weight += weight;
  sums->point_square += weight * Dot(pair.p, pair.p);
  sums->rho += kernel.rho;
  sums->inlier_count += Select(s <= V(kInlierBound), V(1.), V(0.)).UpTo(count);
}

template <typename V>
void Flush(const LaneSums<V>& sums, NormalSystem* system) {
  for (int i = 0, k = 0; i < kRowColumns; ++i) {
    for (int j = i; j < kRowColumns; ++j, ++k) {
      const double sum = SumOfLanes(sums.products.product[k]);
      if (i == 6) {
        system->weighted_square_sum += sum;
      } else if (j == 6) {
        system->right_side[i] -= sum;
      } else {
        system->hessian(i, j) += sum;
        if (i != j) system->hessian(j, i) += sum;
      }
    }
  }
  system->cost += 0.5 * SumOfLanes(sums.rho);
  system->weight_sum += SumOfLanes(sums.weight);
  system->weighted_point_square_sum += SumOfLanes(sums.point_square);
  system->inlier_count += static_cast<int>(SumOfLanes(sums.inlier_count));
}

// The system of the pairs [begin, end), lanes summed over at most 8 values each.
template <typename Rows, RobustKernelType kKernel, typename S>
NormalSystem SumPairs(const Pairs<S>& pairs, int begin, int end, double kernel_width) {
  constexpr int kLanes = Lanes<S>::kCount, kFlush = 8 * kLanes;
  NormalSystem system;
  for (int first = begin; first < end; first += kFlush) {
    LaneSums<Lanes<S>> sums;
    const int last = std::min(end, first + kFlush);
    for (int i = first; i < last; i += kLanes) {
      AddLanes<Rows, kKernel>(pairs, i, last - i, kernel_width, &sums);
    }
    Flush(sums, &system);
  }
  system.pair_count = end - begin;
  system.row_count = system.pair_count * Rows::kRows;
  return system;
}

template <typename S>
using PairSummer = NormalSystem (*)(const Pairs<S>&, int, int, double);

template <typename S>
PairSummer<S> PairSummerOf(ResidualType residual, RobustKernelType kernel) {
  return WithRowsOf(residual, [&](auto rows) {
    return WithKernelType(kernel, [&](auto type) -> PairSummer<S> {
      return SumPairs<decltype(rows), decltype(type)::value, S>;
    });
  });
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
      const PairValues<V> pair = LoadPairs(pairs, i, count);
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
  const PairSummer<S> sum = PairSummerOf<S>(residual, kernel.type);
  return ParallelSum(0, pairs.size, kPairsPerBlock, NormalSystem(),
                     [&](int begin, int end) { return sum(pairs, begin, end, kernel.width); });
}

NormalSystem Linearize(const Association& association, const Rigid3d& target_from_source,
                       ResidualType residual, const RobustKernel& kernel) {
  constexpr int kGrain = 8;
  const PairSummer<float> sum = PairSummerOf<float>(residual, kernel.type);
  const std::unique_ptr<const PairFinder> finder = association.At(target_from_source);
  return ParallelSum(0, association.block_count(), kGrain, NormalSystem(), [&](int begin, int end) {
    PairBuffer pairs;
    pairs.SetCapacity(association.block_capacity());
    NormalSystem system;
    for (int block = begin; block < end; ++block) {
      finder->Find(block, &pairs);
      system += sum(pairs, 0, pairs.size, kernel.width);
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
