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

// What registration asks of a residual that is not among its own. Pairs hold points and normals
// that are moved already (pairs.h): the pose to solve for starts at the identity, and what it
// becomes is the left increment.
class OwnResidual {
 public:
  static constexpr int kMostRows = 3;
  using Cost = std::unique_ptr<ceres::CostFunction>;
  using Block = std::unique_ptr<ReducedBlock>;

  virtual ~OwnResidual() = default;
  virtual int row_count() const = 0;  // from 1 to kMostRows
  virtual NeededNormals needed_normals() const = 0;

  // The rows [a r] of the pairs [begin, end), r in metres (row_sums.h): column c of row k of the
  // pair i becomes rows[(kRowColumns k + c) (end - begin) + i - begin].
  virtual void FillRows(const Pairs<float>& pairs, int begin, int end, float* rows) const = 0;
  virtual void FillRows(const Pairs<double>& pairs, int begin, int end, double* rows) const = 0;

  // All pairs as one block, in units of their sigma. Their arrays are of their size.
  virtual Block Reduced(Pairs<float> pairs, const RobustKernel& kernel) const = 0;
  virtual Block Reduced(Pairs<double> pairs, const RobustKernel& kernel) const = 0;

  // One pair as a block, in units of its sigma.
  virtual Cost OfPair(const Pairs<float>& pairs, int i) const = 0;
  virtual Cost OfPair(const Pairs<double>& pairs, int i) const = 0;
};

// Makes `name` one of ResidualTypeNames(), for all that registers after it: to be called before
// anything does. Throws InputError if the name is taken, or nothing.
void RegisterResidual(const std::string& name, std::unique_ptr<const OwnResidual> residual);

// All of that of a functor (point_functor.h) whose data are those of the functors here: p, q,
// 1 / sigma (7 numbers), with the target's normal n before 1 / sigma (10), or also with the
// source's normal m before it (13), which turns with the pose if kTurned is 9. Which data it has
// tells which normals pairs must have.
template <typename Functor>
class FunctorResidual final : public OwnResidual {
  static constexpr int kSize = Functor::kDataSize, kRows = Functor::kResidualSize;
  static_assert(kSize == 7 || kSize == 10 || kSize == 13,
                "surfit: data of a residual are p, q, 1/sigma; p, q, n, 1/sigma; or p, q, n, m, "
                "1/sigma");
  static_assert(Functor::kTurned < 0 || (kSize == 13 && Functor::kTurned == 9),
                "surfit: of a residual's data, m is what turns");
  static_assert(kRows >= 1 && kRows <= kMostRows, "surfit: a residual has one to three rows");

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
  // Pairs have their arrays in the order of the data; sigma is 1 m for residuals in metres.
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

template <typename Functor>
void RegisterResidual(const std::string& name) {
  RegisterResidual(name, std::make_unique<FunctorResidual<Functor>>());
}

}  // namespace surfit
