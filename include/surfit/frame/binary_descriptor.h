#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

namespace surfit {

// ORB descriptor, 256 bits (Rublee et al. 2011).
using BinaryDescriptor = std::array<std::uint64_t, 4>;

// Number of different bits.
inline int Hamming(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    distance += static_cast<int>(std::bitset<64>(a[i] ^ b[i]).count());
  }
  return distance;
}

}  // namespace surfit
