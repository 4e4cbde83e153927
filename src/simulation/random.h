#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace surfit {

// Random numbers that are identical on all platforms, unlike the distributions of the C++ library.
// At most one argument of a call may draw a number: the evaluation order is unspecified. Not
// thread-safe.
class Random {
 public:
  // Streams of one seed are independent.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : engine_(Mix(Mix(seed) + stream)) {}

  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  // [0, 1)
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  int Index(int count) { return static_cast<int>(Uniform() * count); }  // 0 ... count - 1

  // Standard normal distribution (Box and Muller).
  double Normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double length = std::sqrt(-2 * std::log(1 - Uniform()));
    const double angle = 2 * M_PI * Uniform();
    spare_ = length * std::sin(angle);
    has_spare_ = true;
    return length * std::cos(angle);
  }

  // SplitMix64 hash, a bijection (Steele, Lea and Flood 2014).
  static std::uint64_t Mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

 private:
  std::mt19937_64 engine_;
  bool has_spare_ = false;
  double spare_ = 0;
};

}  // namespace surfit
