#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace surfit {

// The longest match (264 bytes) takes three bytes of what is compressed.
inline constexpr std::size_t kMostLzfExpansion = 88;

// Expands what was compressed by LZF (M. Lehmann): runs of literal bytes and matches with what was
// put out before. Throws InputError unless it expands to exactly `size` bytes.
std::string ExpandLzf(std::string_view compressed, std::size_t size);

}  // namespace surfit
