#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

// GCC warns about vectors that are wider than the registers of the base architecture. This does not
// apply: all functions with such vectors are inlined.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace surfit {

// Instruction sets for Lanes: the base architecture, or AVX2 if the processor supports it. AVX2
// code does not use fused multiply-add, so both sets give bitwise identical results.
struct BaseInstructions {};
struct Avx2Instructions {};

// Code with Lanes<S, Avx2Instructions> must be inlined into a function that is compiled for AVX2
// (see WithInstructions()). Inlining requires an optimised build.
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define SURFIT_INLINE_ALL __attribute__((flatten))
#else
#define SURFIT_INLINE_ALL
#endif
#if defined(__x86_64__) && defined(__GNUC__) && defined(__OPTIMIZE__)
#define SURFIT_HAS_AVX2 1
#define SURFIT_AVX2 __attribute__((target("avx2")))
#else
#define SURFIT_HAS_AVX2 0
#endif

// SIMD vector of float or double values, based on the vector types of GCC and Clang. Operators
// accept scalars. Comparisons return a LaneMask for Select(). Load() and Store() access kCount = 32
// / sizeof(S) consecutive values, at any alignment.
template <typename S, typename Instructions = BaseInstructions>
struct Lanes;

template <typename>
inline constexpr bool kNever = false;

// Result of a comparison of Lanes. Not convertible to bool, because lanes can differ.
template <typename S, typename Instructions>
struct LaneMask {
  using Vector __attribute__((vector_size(32))) = S;
  decltype(Vector{} < Vector{}) v;

  LaneMask operator&(const LaneMask& other) const { return {v & other.v}; }

  template <typename B, typename = std::enable_if_t<std::is_same_v<B, bool>>>
  operator B() const {  // NOLINT(google-explicit-constructor): required for if ()
    static_assert(
        kNever<B>,
        "surfit: a functor for batches must not branch on its values, because it processes "
        "several points at once: use Select(condition, a, b) instead of if or ?:");
    return false;
  }
};

// Defines Lanes for one instruction set. A macro is necessary: the target attribute of a function
// cannot depend on a template argument.
//   LoadUpTo(from, count): the first `count` >= 1 values; further lanes repeat the last value.
//   StoreUpTo(to, count): writes only the first `count` values.
//   StoreTruncated(to): writes kCount integers, rounded towards zero. Values outside of the range
//   of std::int32_t, and NaN, give unspecified integers.
//   LoadHalves(low, high), StoreHalves(low, high): lower and upper half of the lanes at two
//   addresses. StoreHalves() writes the upper half last.
//   UpTo(count): sets the lanes from index `count` on to zero.
//   Select(condition, a, b): condition ? a : b for each lane.
//   Min(a, b), Max(a, b): minimum and maximum of each lane. If a or b is NaN, Min() gives b and
//   Max() gives a.
//   Both(a, b): mask a and b for each lane. Any(mask): true if the mask is set in any lane.
//   Evens(a, b), Odds(a, b): values at even and odd indices of the concatenation of a and b.
// NOLINTBEGIN(bugprone-macro-parentheses): TARGET is an attribute or empty
#define SURFIT_DEFINE_LANES(INSTRUCTIONS, TARGET)                                             \
  template <typename S>                                                                       \
  struct Lanes<S, INSTRUCTIONS> {                                                             \
    static constexpr int kCount = 32 / sizeof(S);                                             \
    using Vector __attribute__((vector_size(32))) = S;                                        \
    using Half __attribute__((vector_size(16))) = S;                                          \
    using Mask = LaneMask<S, INSTRUCTIONS>;                                                   \
                                                                                              \
    TARGET Lanes() : v{} {}                                                                   \
    TARGET Lanes(const Vector& vector) : v(vector) {}           /* NOLINT: implicit */        \
    TARGET Lanes(double x) : v(Vector{} + static_cast<S>(x)) {} /* NOLINT: implicit */        \
                                                                                              \
    TARGET static Lanes Load(const S* from) {                                                 \
      Lanes result;                                                                           \
      std::memcpy(&result.v, from, sizeof(result.v));                                         \
      return result;                                                                          \
    }                                                                                         \
    TARGET static Lanes LoadUpTo(const S* from, int count) {                                  \
      if (count >= kCount) return Load(from);                                                 \
      S values[kCount];                                                                       \
      for (int k = 0; k < kCount; ++k) values[k] = from[k < count ? k : count - 1];           \
      return Load(values);                                                                    \
    }                                                                                         \
    TARGET static Lanes LoadHalves(const S* low, const S* high) {                             \
      Half a, b;                                                                              \
      std::memcpy(&a, low, sizeof(a));                                                        \
      std::memcpy(&b, high, sizeof(b));                                                       \
      if constexpr (kCount == 8) {                                                            \
        return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);                         \
      } else {                                                                                \
        return __builtin_shufflevector(a, b, 0, 1, 2, 3);                                     \
      }                                                                                       \
    }                                                                                         \
    TARGET void StoreHalves(S* low, S* high) const {                                          \
      Half a, b;                                                                              \
      if constexpr (kCount == 8) {                                                            \
        a = __builtin_shufflevector(v, v, 0, 1, 2, 3);                                        \
        b = __builtin_shufflevector(v, v, 4, 5, 6, 7);                                        \
      } else {                                                                                \
        a = __builtin_shufflevector(v, v, 0, 1);                                              \
        b = __builtin_shufflevector(v, v, 2, 3);                                              \
      }                                                                                       \
      std::memcpy(low, &a, sizeof(a));                                                        \
      std::memcpy(high, &b, sizeof(b));                                                       \
    }                                                                                         \
    TARGET void Store(S* to) const { std::memcpy(to, &v, sizeof(v)); }                        \
    TARGET void StoreUpTo(S* to, int count) const {                                           \
      if (count >= kCount) return Store(to);                                                  \
      for (int k = 0; k < count; ++k) to[k] = v[k];                                           \
    }                                                                                         \
    TARGET void StoreTruncated(std::int32_t* to) const {                                      \
      using Integers __attribute__((vector_size(4 * kCount))) = std::int32_t;                 \
      const Integers integers = __builtin_convertvector(v, Integers);                         \
      std::memcpy(to, &integers, sizeof(integers));                                           \
    }                                                                                         \
    TARGET Lanes UpTo(int count) const {                                                      \
      if (count >= kCount) return *this;                                                      \
      S values[kCount];                                                                       \
      for (int k = 0; k < kCount; ++k) values[k] = k < count ? v[k] : S(0);                   \
      return Load(values);                                                                    \
    }                                                                                         \
    TARGET S operator[](int k) const { return v[k]; }                                         \
    TARGET Lanes operator-() const { return -v; }                                             \
    TARGET Lanes& operator+=(const Lanes& other) {                                            \
      v += other.v;                                                                           \
      return *this;                                                                           \
    }                                                                                         \
    TARGET friend Lanes operator+(const Lanes& a, const Lanes& b) { return a.v + b.v; }       \
    TARGET friend Lanes operator-(const Lanes& a, const Lanes& b) { return a.v - b.v; }       \
    TARGET friend Lanes operator*(const Lanes& a, const Lanes& b) { return a.v * b.v; }       \
    TARGET friend Lanes operator/(const Lanes& a, const Lanes& b) { return a.v / b.v; }       \
    TARGET friend Mask operator<(const Lanes& a, const Lanes& b) { return {a.v < b.v}; }      \
    TARGET friend Mask operator>(const Lanes& a, const Lanes& b) { return {a.v > b.v}; }      \
    TARGET friend Mask operator<=(const Lanes& a, const Lanes& b) { return {a.v <= b.v}; }    \
    TARGET friend Mask operator>=(const Lanes& a, const Lanes& b) { return {a.v >= b.v}; }    \
    TARGET friend Lanes Select(const Mask& condition, const Lanes& a, const Lanes& b) {       \
      return condition.v ? a.v : b.v;                                                         \
    }                                                                                         \
    TARGET friend Lanes Min(const Lanes& a, const Lanes& b) { return a.v < b.v ? a.v : b.v; } \
    TARGET static bool Any(const Mask& mask) {                                                \
      using Words __attribute__((vector_size(32))) = std::uint64_t;                           \
      const Words words = reinterpret_cast<Words>(mask.v);                                    \
      return (words[0] | words[1] | words[2] | words[3]) != 0;                                \
    }                                                                                         \
    TARGET static Mask Both(const Mask& a, const Mask& b) { return {a.v & b.v}; }             \
    TARGET friend Lanes Max(const Lanes& a, const Lanes& b) { return a.v < b.v ? b.v : a.v; } \
    TARGET friend Lanes abs(const Lanes& x) {                                                 \
      using Bits = decltype(x.v < x.v);                                                       \
      const Bits sign = reinterpret_cast<Bits>(-Vector{});                                    \
      return reinterpret_cast<Vector>(reinterpret_cast<Bits>(x.v) & ~sign);                   \
    }                                                                                         \
    TARGET friend Lanes Evens(const Lanes& a, const Lanes& b) {                               \
      if constexpr (kCount == 8) {                                                            \
        return __builtin_shufflevector(a.v, b.v, 0, 2, 4, 6, 8, 10, 12, 14);                  \
      } else {                                                                                \
        return __builtin_shufflevector(a.v, b.v, 0, 2, 4, 6);                                 \
      }                                                                                       \
    }                                                                                         \
    TARGET friend Lanes Odds(const Lanes& a, const Lanes& b) {                                \
      if constexpr (kCount == 8) {                                                            \
        return __builtin_shufflevector(a.v, b.v, 1, 3, 5, 7, 9, 11, 13, 15);                  \
      } else {                                                                                \
        return __builtin_shufflevector(a.v, b.v, 1, 3, 5, 7);                                 \
      }                                                                                       \
    }                                                                                         \
    TARGET friend Lanes sqrt(const Lanes& x) {                                                \
      Lanes result;                                                                           \
      for (int k = 0; k < kCount; ++k) result.v[k] = std::sqrt(x.v[k]);                       \
      return result;                                                                          \
    }                                                                                         \
    TARGET friend Lanes log(const Lanes& x) {                                                 \
      Lanes result;                                                                           \
      for (int k = 0; k < kCount; ++k) result.v[k] = std::log(x.v[k]);                        \
      return result;                                                                          \
    }                                                                                         \
                                                                                              \
    Vector v;                                                                                 \
  };
// NOLINTEND(bugprone-macro-parentheses)

SURFIT_DEFINE_LANES(BaseInstructions, )
#if SURFIT_HAS_AVX2
SURFIT_DEFINE_LANES(Avx2Instructions, SURFIT_AVX2)
#endif
#undef SURFIT_DEFINE_LANES

// Select() of scalars, so that code for lanes also compiles for float and double.
inline double Select(bool condition, double a, double b) { return condition ? a : b; }
inline float Select(bool condition, float a, float b) { return condition ? a : b; }

template <typename F>
SURFIT_INLINE_ALL auto WithBaseInstructions(const F& f) {
  return f(BaseInstructions());
}
#if SURFIT_HAS_AVX2
template <typename F>
SURFIT_AVX2 SURFIT_INLINE_ALL auto WithAvx2Instructions(const F& f) {
  return f(Avx2Instructions());
}
#endif

// True if WithInstructions() uses AVX2: an optimised x86-64 build, a processor with AVX2, and no
// SURFIT_INSTRUCTIONS=base in the environment. Constant after the first call. Thread-safe.
bool UsesAvx2();

// Calls f(instructions) with the best instruction set, and returns the result. All functions called
// by f are inlined, so they must be defined in the same file or its headers. Captures and result of
// f must not contain Lanes.
template <typename F>
auto WithInstructions(const F& f) {
#if SURFIT_HAS_AVX2
  if (UsesAvx2()) return WithAvx2Instructions(f);
#endif
  return WithBaseInstructions(f);
}

}  // namespace surfit

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
