#include "registration/pair_buffer.h"

#include <algorithm>

namespace surfit {
namespace {

constexpr int kLanes = PairBuffer::kLanes;
constexpr int kGroupsPerFlush = 8;  // single precision sums over at most 8 values a lane
constexpr int kColumns = 7;         // six of A, then b
constexpr int kProducts = kColumns * (kColumns + 1) / 2;

// Sums of products of the columns of [A b], and of w and w |p|^2, one a lane.
struct LaneSums {
  float product[kProducts][kLanes] = {};
  float weight[kLanes] = {};
  float point_square[kLanes] = {};
};

void AddGroup(const PairBuffer& pairs, int first, LaneSums* sums) {
  float column[kColumns][kLanes];
  float weighted[kColumns][kLanes];
  const float *px = &pairs.px[first], *py = &pairs.py[first], *pz = &pairs.pz[first];
  const float *qx = &pairs.qx[first], *qy = &pairs.qy[first], *qz = &pairs.qz[first];
  const float *nx = &pairs.nx[first], *ny = &pairs.ny[first], *nz = &pairs.nz[first];
  const float* weight = &pairs.weight[first];
  for (int l = 0; l < kLanes; ++l) {
    column[0][l] = py[l] * nz[l] - pz[l] * ny[l];
    column[1][l] = pz[l] * nx[l] - px[l] * nz[l];
    column[2][l] = px[l] * ny[l] - py[l] * nx[l];
    column[3][l] = nx[l];
    column[4][l] = ny[l];
    column[5][l] = nz[l];
    column[6][l] = nx[l] * (qx[l] - px[l]) + ny[l] * (qy[l] - py[l]) + nz[l] * (qz[l] - pz[l]);
    sums->weight[l] += weight[l];
    sums->point_square[l] += weight[l] * (px[l] * px[l] + py[l] * py[l] + pz[l] * pz[l]);
  }
  for (int i = 0; i < kColumns; ++i) {
    for (int l = 0; l < kLanes; ++l) weighted[i][l] = weight[l] * column[i][l];
  }
  int k = 0;
  for (int i = 0; i < kColumns; ++i) {
    for (int j = i; j < kColumns; ++j, ++k) {
      for (int l = 0; l < kLanes; ++l) sums->product[k][l] += weighted[i][l] * column[j][l];
    }
  }
}

double SumOfLanes(const float* lanes) {
  double sum = 0;
  for (int l = 0; l < kLanes; ++l) sum += static_cast<double>(lanes[l]);
  return sum;
}

void Flush(const LaneSums& sums, NormalSystem* system) {
  int k = 0;
  for (int i = 0; i < kColumns; ++i) {
    for (int j = i; j < kColumns; ++j, ++k) {
      const double sum = SumOfLanes(sums.product[k]);
      if (i == 6) {
        system->weighted_square_sum += sum;
      } else if (j == 6) {
        system->right_side[i] += sum;
      } else {
        system->hessian(i, j) += sum;
        if (i != j) system->hessian(j, i) += sum;
      }
    }
  }
  system->weight_sum += SumOfLanes(sums.weight);
  system->weighted_point_square_sum += SumOfLanes(sums.point_square);
}

}  // namespace

void AddPairs(PairBuffer* pairs, NormalSystem* system) {
  const int padded = (pairs->size + kLanes - 1) / kLanes * kLanes;
  for (auto* array : {&pairs->px, &pairs->py, &pairs->pz, &pairs->qx, &pairs->qy, &pairs->qz,
                      &pairs->nx, &pairs->ny, &pairs->nz, &pairs->weight}) {
    std::fill(array->begin() + pairs->size, array->begin() + padded, 0.f);
  }
  for (int first = 0; first < padded; first += kLanes * kGroupsPerFlush) {
    LaneSums sums;
    const int end = std::min(padded, first + kLanes * kGroupsPerFlush);
    for (int group = first; group < end; group += kLanes) AddGroup(*pairs, group, &sums);
    Flush(sums, system);
  }
  system->pair_count += pairs->size;
  system->inlier_count += pairs->inlier_count;
}

}  // namespace surfit
