#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace surfit {

template <typename S>
struct LaneMask;

// Several numbers of type float or double to compute with at once, in the vector types of GCC and
// Clang. Mixes with plain numbers; comparisons give a LaneMask for Select().
template <typename S>
struct Lanes {
  static constexpr int kCount = 16 / sizeof(S);
  using Vector __attribute__((vector_size(16))) = S;

  Lanes() : v{} {}
  Lanes(Vector vector) : v(vector) {}                   // NOLINT(google-explicit-constructor)
  Lanes(double x) : v(Vector{} + static_cast<S>(x)) {}  // NOLINT(google-explicit-constructor)

  static Lanes Load(const S* from) {
    Lanes result;
    std::memcpy(&result.v, from, sizeof(result.v));
    return result;
  }
  // The first `count` >= 1 values, the last of them repeated.
  static Lanes LoadUpTo(const S* from, int count) {
    if (count >= kCount) return Load(from);
    Lanes result(from[count - 1]);
    for (int k = 0; k < count; ++k) result.v[k] = from[k];
    return result;
  }
  // Zeros beyond the first `count` values.
  Lanes UpTo(int count) const {
    Lanes result = *this;
    for (int k = count; k < kCount; ++k) result.v[k] = 0;
    return result;
  }
  S operator[](int k) const { return v[k]; }
  Lanes operator-() const { return -v; }
  Lanes& operator+=(Lanes other) {
    v += other.v;
    return *this;
  }

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend LaneMask<S> operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
  friend LaneMask<S> operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
  friend LaneMask<S> operator<=(Lanes a, Lanes b) { return {a.v <= b.v}; }
  friend LaneMask<S> operator>=(Lanes a, Lanes b) { return {a.v >= b.v}; }

  Vector v;
};

template <typename>
inline constexpr bool kNever = false;

// The outcome of a comparison, one per lane. It is no bool: lanes may differ.
template <typename S>
struct LaneMask {
  decltype(typename Lanes<S>::Vector{} < typename Lanes<S>::Vector{}) v;

  template <typename B, typename = std::enable_if_t<std::is_same_v<B, bool>>>
  operator B() const {
    static_assert(
        kNever<B>,
        "surfit: a functor for batches must be free of branches on its numbers, as it runs "
        "for several points at once: use Select(condition, a, b) instead of if or ?:");
    return false;
  }
};

// condition ? a : b, lane by lane.
template <typename S>
Lanes<S> Select(LaneMask<S> condition, Lanes<S> a, Lanes<S> b) {
  return condition.v ? a.v : b.v;
}
inline double Select(bool condition, double a, double b) { return condition ? a : b; }

// f of each lane.
template <typename S, typename F>
Lanes<S> ForEachLane(Lanes<S> x, const F& f) {
  for (int k = 0; k < Lanes<S>::kCount; ++k) x.v[k] = f(x.v[k]);
  return x;
}
template <typename S>
Lanes<S> sqrt(Lanes<S> x) {
  return ForEachLane(x, [](S value) { return std::sqrt(value); });
}
template <typename S>
Lanes<S> log(Lanes<S> x) {
  return ForEachLane(x, [](S value) { return std::log(value); });
}

}  // namespace surfit
