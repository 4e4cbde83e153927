#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace surfit {

using Words = std::vector<std::string_view>;

// The words of a line, which blanks, tabs and a carriage return separate.
Words SplitWords(std::string_view line);

// Throws InputError naming the word unless it is an integer from 0.
std::int64_t ParseCount(std::string_view word);

}  // namespace surfit
