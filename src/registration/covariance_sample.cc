#include "registration/covariance_sample.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/normal_system.h"

namespace surfit {
namespace {

constexpr int kRowsPerTask = 8;

bool HasNormal(const FrameLevel& level, int i) {
  return level.vertex.z[i] > 0 && level.normal.z[i] != 0;
}

// C and the number of points of a level, from some of its rows.
struct LevelMoments {
  Matrix6d covariance = Matrix6d::Zero();
  double count = 0;

  void Add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    Vector6d row;
    row << point.cross(normal), normal;
    covariance.noalias() += row * row.transpose();
    ++count;
  }
  LevelMoments& operator+=(const LevelMoments& other) {
    covariance += other.covariance;
    count += other.count;
    return *this;
  }
};

// Every kRowsApart-th row stands for all, and every second pixel of it.
LevelMoments MomentsOf(const FrameLevel& level) {
  constexpr int kRowsApart = 4, kPixelsApart = 2;
  const int width = level.vertex.width(), rows = level.vertex.height() / kRowsApart;
  LevelMoments moments =
      ParallelSum(0, rows, kRowsPerTask, LevelMoments(), [&](int begin, int end) {
        LevelMoments sum;
        for (int row = begin; row < end; ++row) {
          for (int u = 0; u < width; u += kPixelsApart) {
            const int i = row * kRowsApart * width + u;
            if (!HasNormal(level, i)) continue;
            sum.Add(level.vertex(u, row * kRowsApart).cast<double>(),
                    level.normal(u, row * kRowsApart).cast<double>());
          }
        }
        return sum;
      });
  moments.covariance *= kRowsApart * kPixelsApart;
  moments.count *= kRowsApart * kPixelsApart;
  return moments;
}

// The chance of a point to be in the sample: `even` for each and `slope` times its leverage, which
// is the square of whitened rows, L^-1 c with C = L L'.
class SampleChance {
 public:
  SampleChance(const LevelMoments& moments, int count)
      : even_(static_cast<float>(0.5 * count / moments.count)) {
    constexpr double kFloor = 1e-4;  // of directions that nothing holds, as a share of the mean
    Matrix6d covariance = moments.covariance;
    covariance.diagonal().head<3>().array() += kFloor * moments.covariance.trace();
    covariance.diagonal().tail<3>().array() += kFloor * moments.covariance.trace();
    const Matrix6d whitener =
        covariance.llt().matrixL().solve(Matrix6d::Identity()) * std::sqrt(0.5 * count / 6);
    for (int i = 0, k = 0; i < 6; ++i) {
      for (int j = 0; j <= i; ++j, ++k) whitener_[k] = static_cast<float>(whitener(i, j));
    }
  }

  // Of the pixels of a row, 0 where there is no point with a normal.
  void OfRow(const FrameLevel& level, int v, float* chances) const {
    const int width = level.vertex.width();
    const float *x = level.vertex.x.row(v), *y = level.vertex.y.row(v), *z = level.vertex.z.row(v);
    const float *nx = level.normal.x.row(v), *ny = level.normal.y.row(v),
                *nz = level.normal.z.row(v);
    WithInstructions([&](auto) {
      for (int u = 0; u < width; ++u) {
        const float c[6] = {y[u] * nz[u] - z[u] * ny[u],
                            z[u] * nx[u] - x[u] * nz[u],
                            x[u] * ny[u] - y[u] * nx[u],
                            nx[u],
                            ny[u],
                            nz[u]};
        float leverage = 0;
        for (int i = 0, k = 0; i < 6; ++i) {
          float whitened = 0;
          for (int j = 0; j <= i; ++j, ++k) whitened += whitener_[k] * c[j];
          leverage += whitened * whitened;
        }
        const float chance = even_ + leverage;
        chances[u] = (z[u] > 0) & (nz[u] != 0) ? chance : 0.f;
      }
    });
  }

 private:
  float even_;
  float whitener_[21];
};

// The pixels of a row that are taken. Each row starts elsewhere (golden ratio), lest columns form.
std::vector<int> TakeFromRow(const FrameLevel& level, int v, const SampleChance& chance) {
  std::vector<float> chances(level.vertex.width());
  chance.OfRow(level, v, chances.data());
  std::vector<int> taken;
  double sum = std::fmod(0.6180339887498949 * v, 1);
  for (std::size_t u = 0; u < chances.size(); ++u) {
    sum += std::min(chances[u], 1.f);
    if (sum < 1) continue;
    sum -= 1;
    taken.push_back(v * level.vertex.width() + static_cast<int>(u));
  }
  return taken;
}

FrameLevel Packed(const FrameLevel& level, const std::vector<std::vector<int>>& pixels_of_rows) {
  std::vector<int> first = {0};
  for (const auto& pixels : pixels_of_rows) {
    first.push_back(first.back() + static_cast<int>(pixels.size()));
  }
  const int width = level.vertex.width(), height = (first.back() + width - 1) / width;
  FrameLevel packed{level.camera, VectorImage(width, height), VectorImage(width, height), {}};
  const auto copy = [&](const VectorImage& from, int pixel, VectorImage* to, int i) {
    to->x[i] = from.x[pixel];
    to->y[i] = from.y[pixel];
    to->z[i] = from.z[pixel];
  };
  ParallelFor(0, static_cast<int>(pixels_of_rows.size()), kRowsPerTask, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      int i = first[v];
      for (const int pixel : pixels_of_rows[v]) {
        copy(level.vertex, pixel, &packed.vertex, i);
        copy(level.normal, pixel, &packed.normal, i++);
      }
    }
  });
  return packed;
}

}  // namespace

std::optional<FrameLevel> CovarianceSample(const FrameLevel& level, int count) {
  const LevelMoments moments = MomentsOf(level);
  if (moments.count <= count) return std::nullopt;
  std::vector<std::vector<int>> pixels(level.vertex.height());
  const SampleChance chance(moments, count);
  ParallelFor(0, level.vertex.height(), kRowsPerTask, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) pixels[v] = TakeFromRow(level, v, chance);
  });
  return Packed(level, pixels);
}

}  // namespace surfit
