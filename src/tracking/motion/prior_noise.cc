#include "tracking/motion/prior_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surfit {
namespace {

// Variances of drift and noise: n drift + 2 noise is the spread over n = 1, 2, 4, ... frames.
struct DriftAndNoise {
  double drift = 0, noise = 0;
};

// Reweighted least squares. The standard deviation of a spread is proportional to the spread, and
// to the inverse square root of the number of independent windows. A minimum over the scales would
// be too small, because the spread of a few windows varies by half.
DriftAndNoise FitOfSpread(const std::vector<double>& spread, const std::vector<double>& windows) {
  constexpr int kIterations = 20;
  std::vector<double> expected = spread;
  DriftAndNoise fit;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right_side = Eigen::Vector2d::Zero();
    for (std::size_t scale = 0; scale < spread.size(); ++scale) {
      const Eigen::Vector2d row(std::ldexp(1, static_cast<int>(scale)), 2);
      const double weight = windows[scale] / (expected[scale] * expected[scale]);
      hessian += weight * row * row.transpose();
      right_side += weight * spread[scale] * row;
    }
    const double determinant = hessian(0, 0) * hessian(1, 1) - hessian(0, 1) * hessian(1, 0);
    fit.drift = right_side[0] / hessian(0, 0);
    fit.noise = 0;
    if (determinant > 1e-9 * hessian(0, 0) * hessian(1, 1)) {
      const double drift =
          (hessian(1, 1) * right_side[0] - hessian(0, 1) * right_side[1]) / determinant;
      const double noise =
          (hessian(0, 0) * right_side[1] - hessian(1, 0) * right_side[0]) / determinant;
      if (drift < 0) {
        fit = {0, right_side[1] / hessian(1, 1)};
      } else if (noise > 0) {
        fit = {drift, noise};
      }
    }
    for (std::size_t scale = 0; scale < spread.size(); ++scale) {
      expected[scale] = std::ldexp(fit.drift, static_cast<int>(scale)) + 2 * fit.noise;
    }
  }
  return fit;
}

// Upper bound of the prior's drift. The spread of few windows is uncertain.
double UpperBound(const NoiseStatistics& statistics) {
  constexpr double kRelativeSigma = 1.5;  // of a lower quartile of one window
  double bound = statistics.prior_third / 6;
  for (std::size_t scale = 0; scale < statistics.spread.size(); ++scale) {
    const double uncertainty = kRelativeSigma / std::sqrt(statistics.windows[scale]);
    bound = std::min(
        bound, std::ldexp(statistics.spread[scale], -static_cast<int>(scale)) * (1 + uncertainty));
  }
  return bound;
}

// White noise of the prior. 0 if it is not significant.
double PriorNoise(const NoiseStatistics& statistics) {
  constexpr double kSignificant = 2;  // standard deviations
  const PriorPart &one = statistics.part, &two = statistics.part_of_two;
  const double noise = (2 * one.variance - two.variance) / 20;
  const double sigma = std::hypot(2 * one.sigma, two.sigma) / 20;
  return two.sigma > 0 && noise > kSignificant * sigma ? noise : 0;
}

// Combines the guess of equal drifts, which is uncertain by its own size, with the measured part.
double PriorDrift(const NoiseStatistics& statistics, double drift_of_both, double prior_noise) {
  constexpr double kLeastRatio = 0.1;
  const double bound = UpperBound(statistics);
  const double guess = std::min(drift_of_both / 2, bound);
  const double measured = (statistics.part.variance - 20 * prior_noise) / 6;
  const double sigma = statistics.part.sigma / 6;
  if (!(guess > 0) || !(sigma > 0)) return guess;
  const double of_guess = 1 / (guess * guess), of_measured = 1 / (sigma * sigma);
  const double drift = (of_guess * guess + of_measured * measured) / (of_guess + of_measured);
  return std::clamp(drift, kLeastRatio * guess, bound);
}

// Spread of the registration alone.
double RegisteredSpread(const NoiseStatistics& statistics, const SourceNoise& noise, int scale) {
  const double frames = std::ldexp(1, scale);
  return std::max(0.,
                  statistics.spread[scale] - frames * noise.prior_drift - 2 * noise.prior_noise);
}

// The spread grows with a power of the number of frames, up to the age of the map. The exponent is
// that of the largest scales. Without an age, the drift is that of the largest scale.
double RegisteredDrift(const NoiseStatistics& statistics, const SourceNoise& noise) {
  constexpr int kScales = 2;  // of the exponent
  const int last = static_cast<int>(statistics.spread.size()) - 1;
  const double frames = std::ldexp(1, last);
  const double spread =
      std::max(2 * noise.registered_noise, RegisteredSpread(statistics, noise, last));
  const double age = std::max(frames, statistics.model_age_frames);
  const double before = last >= kScales ? RegisteredSpread(statistics, noise, last - kScales) : 0;
  const double exponent = before > 0 ? std::clamp(std::log2(spread / before) / kScales, 0., 1.) : 1;
  return spread * std::pow(age / frames, exponent) / age;
}

}  // namespace

SourceNoise EstimateNoise(const NoiseStatistics& statistics) {
  SourceNoise noise;
  noise.spread = statistics.spread;
  const auto [drift, white] = FitOfSpread(statistics.spread, statistics.windows);
  noise.prior_noise = PriorNoise(statistics);
  noise.registered_noise = std::max(statistics.smallest, white - noise.prior_noise);
  noise.prior_drift =
      std::max(statistics.smallest, PriorDrift(statistics, drift, noise.prior_noise));
  const int last = static_cast<int>(statistics.spread.size()) - 1;
  noise.registered_bounded =
      std::max(noise.registered_noise, RegisteredSpread(statistics, noise, last) / 2);
  noise.registered_drift = RegisteredDrift(statistics, noise);
  return noise;
}

PriorPart MeasurePriorPart(const std::vector<Eigen::Vector3d>& prior,
                           const std::vector<Eigen::Vector3d>& registered) {
  // A chi-square variable of three degrees of freedom exceeds the bound with probability 1e-6.
  constexpr double kMaxSquare = 30;
  constexpr double kOverlap = 2;  // third differences share motions
  std::vector<double> squares;
  for (std::size_t i = 0; i < prior.size(); ++i) {
    squares.push_back((prior[i] - registered[i]).squaredNorm());
  }
  const double max_square = kMaxSquare * QuartileVariance(squares);
  double sum = 0, square_sum = 0, count = 0;
  for (std::size_t i = 0; i < prior.size(); ++i) {
    if (squares[i] > max_square) continue;
    const double product = (prior[i] - registered[i]).dot(prior[i]) / 3;
    sum += product;
    square_sum += product * product;
    count += 1;
  }
  if (count < 2) return {};
  const double mean = sum / count;
  const double variance = std::max(0., square_sum / count - mean * mean);
  return {mean, std::sqrt(kOverlap * variance / count)};
}

double QuartileVariance(std::vector<double> squares) {
  // A chi-square variable of three degrees of freedom is below this value with probability 0.25.
  constexpr double kLowerQuartile = 1.2125;
  if (squares.empty()) return 0;
  const auto quartile = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 4);
  std::nth_element(squares.begin(), quartile, squares.end());
  return *quartile / kLowerQuartile;
}

}  // namespace surfit
