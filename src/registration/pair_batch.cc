#include "registration/pair_batch.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {

BatchData<PointToPlane, float> MakeBatch(const std::vector<PairBuffer>& rows) {
  std::vector<std::size_t> first = {0};
  for (const PairBuffer& row : rows) first.push_back(first.back() + row.size);
  BatchData<PointToPlane, float> batch;
  batch.Resize(first.back());
  ParallelFor(0, static_cast<int>(rows.size()), 8, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const PairBuffer& row = rows[v];
      const std::vector<float>* columns[] = {&row.px, &row.py, &row.pz, &row.qx, &row.qy,
                                             &row.qz, &row.nx, &row.ny, &row.nz};
      int channel = 0;
      for (const auto* column : columns) {
        std::copy_n(column->begin(), row.size, batch.array(channel++) + first[v]);
      }
      float* inverse_sigma = batch.array(channel) + first[v];
      for (int i = 0; i < row.size; ++i) inverse_sigma[i] = std::sqrt(row.information[i]);
    }
  });
  batch.Pad();
  return batch;
}

}  // namespace surfit
