#include "io/words.h"

#include <algorithm>
#include <charconv>

#include "surfit/core/error.h"

namespace surfit {

Words SplitWords(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  Words words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words.back().size());
  }
}

std::int64_t ParseCount(std::string_view word) {
  std::int64_t count = -1;
  const char* const end = word.data() + word.size();
  const auto [parsed, error] = std::from_chars(word.data(), end, count);
  if (error != std::errc() || parsed != end || count < 0) {
    throw InputError(Concat("the count is '", word, "', must be an integer from 0"));
  }
  return count;
}

}  // namespace surfit
