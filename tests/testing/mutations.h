#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>

#include "testing/recordings.h"

namespace surfit::testing {

using Random = std::mt19937_64;

// Random index below `end`, which must not be 0.
inline std::size_t Below(std::size_t end, Random* random) {
  return std::uniform_int_distribution<std::size_t>(0, end - 1)(*random);
}

// Applies one to four changes, and then writes a random number into the first 400 bytes of half of
// the longer texts. A change flips a bit, replaces a byte, sets a number to an extreme value,
// truncates, or duplicates a piece. Numbers have 2, 4 or 8 bytes.
inline std::string Mutated(std::string bytes, Random* random) {
  constexpr std::int64_t kExtremes[] = {-1, 0, 1, INT32_MAX, INT64_MAX, 1LL << 40, 65536, 16384};
  for (std::size_t changes = 1 + Below(4, random); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = Below(bytes.size(), random);
    const std::size_t count = std::min<std::size_t>(bytes.size() - at, 2u << Below(3, random));
    switch (Below(5, random)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << Below(8, random)));
        break;
      case 1:
        bytes[at] = static_cast<char>(Below(256, random));
        break;
      case 2:
        bytes.replace(at, count, LittleEndian(kExtremes[Below(8, random)]).substr(0, count));
        break;
      case 3:
        bytes.resize(at);
        break;
      default:
        bytes.insert(at, bytes.substr(at, Below(200, random)));
    }
  }
  // Half of all changes are in the header, which contains sizes.
  if (Below(2, random) == 0 && bytes.size() > 400) {
    const std::size_t at = Below(400, random);
    bytes.replace(at, 4, LittleEndian(static_cast<std::int32_t>((*random)())));
  }
  return bytes;
}

}  // namespace surfit::testing
