#pragma once

#include <ceres/autodiff_cost_function.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "cost_functions/reduced_batch.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Interface of a user-defined registration residual. Pairs (association.h) contain source points
// and normals at the current pose. The pose therefore starts at the identity, and the solution
// is the left perturbation. Const members must be thread-safe.
class OwnResidual {
 public:
  static constexpr int kMaxRows = 3;
  using Cost = std::unique_ptr<ceres::CostFunction>;
  using Block = std::unique_ptr<ReducedBlock>;

  virtual ~OwnResidual() = default;
  virtual int row_count() const = 0;  // 1 to kMaxRows
  virtual NeededNormals needed_normals() const = 0;

  // Computes the rows [a r] (row_sums.h) of the correspondences [begin, end) at the identity,
  // r in m. Element (k, c) of correspondence i is rows[(kRowColumns k + c) (end - begin) + i -
  // begin].
  virtual void FillRows(const Pairs<float>& pairs, int begin, int end, float* rows) const = 0;
  virtual void FillRows(const Pairs<double>& pairs, int begin, int end, double* rows) const = 0;

  // Residual block of all correspondences, in standard deviations. The arrays have exact size.
  virtual Block Reduced(Pairs<float> pairs, const RobustKernel& kernel) const = 0;
  virtual Block Reduced(Pairs<double> pairs, const RobustKernel& kernel) const = 0;

  // Residual block of one correspondence, in standard deviations.
  virtual Cost OfPair(const Pairs<float>& pairs, int i) const = 0;
  virtual Cost OfPair(const Pairs<double>& pairs, int i) const = 0;
};

// Adds a residual with its name to ResidualTypeNames(), until the process ends. Not thread-safe:
// call before any registration. `residual` must not be null. Throws InputError if the name is empty
// or already used.
void RegisterResidual(const std::string& name, std::unique_ptr<const OwnResidual> residual);

// OwnResidual of a functor (point_functor.h), which must be default-constructible. Its residuals
// must be distances in m times 1 / sigma. The data size of the functor selects its data:
// - 7: p, q, 1 / sigma,
// - 10: p, q, target normal n, 1 / sigma,
// - 13: p, q, n, source normal m, 1 / sigma; m is rotated by the pose if kTurned is 9.
template <typename Functor>
class FunctorResidual final : public OwnResidual {
  static constexpr int kSize = Functor::kDataSize, kRows = Functor::kResidualSize;
  static_assert(kSize == 7 || kSize == 10 || kSize == 13,
                "surfit: the data of a residual must be p, q, 1/sigma; p, q, n, 1/sigma; or p, "
                "q, n, m, 1/sigma");
  static_assert(Functor::kTurned < 0 || (kSize == 13 && Functor::kTurned == 9),
                "surfit: kTurned of a residual must be negative, or 9 with 13 data values");
  static_assert(kRows >= 1 && kRows <= kMaxRows, "surfit: a residual must have one to three rows");

 public:
  int row_count() const override { return kRows; }
  NeededNormals needed_normals() const override {
    if (kSize == 7) return NeededNormals::kNone;
    return kSize == 10 ? NeededNormals::kTarget : NeededNormals::kBoth;
  }

  void FillRows(const Pairs<float>& pairs, int begin, int end, float* rows) const override {
    Fill(pairs, begin, end, rows);
  }
  void FillRows(const Pairs<double>& pairs, int begin, int end, double* rows) const override {
    Fill(pairs, begin, end, rows);
  }
  Block Reduced(Pairs<float> pairs, const RobustKernel& kernel) const override {
    return ReducedOf(std::move(pairs), kernel);
  }
  Block Reduced(Pairs<double> pairs, const RobustKernel& kernel) const override {
    return ReducedOf(std::move(pairs), kernel);
  }
  Cost OfPair(const Pairs<float>& pairs, int i) const override { return BlockOf(pairs, i); }
  Cost OfPair(const Pairs<double>& pairs, int i) const override { return BlockOf(pairs, i); }

 private:
  // Pairs::Arrays() and functor data have the same order. 1 / sigma is 1, because the
  // residuals are in m.
  template <typename S>
  static void Fill(const Pairs<S>& pairs, int begin, int end, S* to) {
    WithInstructions([&](auto instructions) {
      using V = Lanes<S, decltype(instructions)>;
      const auto arrays = pairs.Arrays();
      for (int i = begin; i < end; i += V::kCount) {
        const int count = std::min(end - i, V::kCount);
        V data[kSize];
        for (int k = 0; k + 1 < kSize; ++k) data[k] = V::LoadUpTo(arrays[k]->data() + i, count);
        data[kSize - 1] = V(1.);
        V rows[kRows][kRowColumns];
        BatchRows<Functor, V>::LinearizeAtStart(Functor(), data, rows);
        for (int k = 0; k < kRows * kRowColumns; ++k) {
          rows[k / kRowColumns][k % kRowColumns].StoreUpTo(to + k * (end - begin) + i - begin,
                                                           count);
        }
      }
    });
  }

  template <typename S>
  static Block ReducedOf(Pairs<S> pairs, const RobustKernel& kernel) {
    for (S& information : pairs.information) information = std::sqrt(information);
    const auto arrays = pairs.Arrays();
    typename BatchData<Functor, S>::Arrays data;
    for (int k = 0; k + 1 < kSize; ++k) data[k] = std::move(*arrays[k]);
    data[kSize - 1] = std::move(pairs.information);
    return std::make_unique<ReducedBatch<Functor, S>>(
        Functor(), BatchData<Functor, S>(std::move(data)), kernel);
  }

  template <typename S>
  static Cost BlockOf(const Pairs<S>& pairs, int i) {
    auto functor = std::make_unique<Functor>();
    const auto arrays = pairs.Arrays();
    for (int k = 0; k + 1 < kSize; ++k) functor->data[k] = (*arrays[k])[i];
    functor->data[kSize - 1] = std::sqrt(static_cast<double>(pairs.information[i]));
    return std::make_unique<ceres::AutoDiffCostFunction<Functor, kRows, kPoseSize>>(
        functor.release());
  }
};

// Registers a FunctorResidual. For example: RegisterResidual<MyResidual>("my_residual").
template <typename Functor>
void RegisterResidual(const std::string& name) {
  RegisterResidual(name, std::make_unique<FunctorResidual<Functor>>());
}

}  // namespace surfit
