#include "io/stamps/time_words.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/median.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kUnits[] = {0, 3, 6, 9};  // decimals of s, ms, us, ns
constexpr const char* kDigits = "0123456789";

// Sorts the numbers. Repeated numbers give no interval.
std::vector<double> Intervals(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  std::vector<double> intervals;
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] > numbers[i - 1]) intervals.push_back(numbers[i] - numbers[i - 1]);
  return intervals;
}

// True for frame numbers: integers whose steps are multiples of the smallest step, or irregular
// (selected frames). Timestamps of a camera in ms have steps that are nearly equal, but rounded up
// or down.
bool AreFrameNumbers(const std::vector<double>& stamps, const std::vector<double>& intervals,
                     double usual) {
  constexpr double kMinClock = 1e11;  // ms since 1970 are above, frame numbers are below
  constexpr double kRegular = 0.2;
  if (stamps[0] >= kMinClock) return false;
  const double smallest = *std::min_element(intervals.begin(), intervals.end());
  std::size_t regular = 0;
  bool are_steps = true;
  for (const double stamp : stamps)
    if (stamp != std::floor(stamp)) return false;
  for (const double interval : intervals) {
    regular += std::abs(interval - usual) <= kRegular * usual;
    are_steps = are_steps && std::fmod(interval, smallest) == 0;
  }
  return are_steps || 2 * regular < intervals.size();
}

// Digits after the point; empty unless the word has the form digits.digits.
std::string_view Fraction(std::string_view word) {
  const std::size_t point = word.find('.');
  if (point == word.npos || point == 0 || point + 1 == word.size()) return {};
  if (word.find_first_not_of(kDigits) != point) return {};
  if (word.find_first_not_of(kDigits, point + 1) != word.npos) return {};
  return word.substr(point + 1);
}

// Adds the leading zeros that are missing if fractions were written as integers. Such fractions
// have different lengths, and no leading zero. Empty for other words.
std::vector<std::string> Padded(const std::vector<std::string>& words) {
  std::size_t shortest = std::string::npos, longest = 0;
  for (const std::string& word : words) {
    const std::string_view fraction = Fraction(word);
    if (fraction.empty() || (fraction.size() > 1 && fraction[0] == '0')) return {};
    shortest = std::min(shortest, fraction.size());
    longest = std::max(longest, fraction.size());
  }
  if (words.empty() || shortest == longest || longest > 9) return {};
  const std::size_t digits = (longest + 2) / 3 * 3;  // ms, us or ns
  std::vector<std::string> padded;
  for (std::string word : words) {
    const std::string_view fraction = Fraction(word);
    word.insert(word.size() - fraction.size(), digits - fraction.size(), '0');
    padded.push_back(word);
  }
  return padded;
}

// Mean deviation of the intervals from their median, relative to the median.
double Irregularity(const std::vector<double>& numbers) {
  const std::vector<double> intervals = Intervals(numbers);
  if (intervals.empty()) return HUGE_VAL;
  const double usual = MedianOf(intervals);
  double sum = 0;
  for (const double interval : intervals) sum += std::abs(interval / usual - 1);
  return sum / static_cast<double>(intervals.size());
}

// Converts numbers in units of 10^-decimals s to s, with a single rounding.
std::vector<double> InSeconds(const std::vector<std::string>& words, int decimals) {
  std::vector<double> stamps_s;
  stamps_s.reserve(words.size());
  for (const std::string& word : words) {
    const bool is_plain = word.find_first_of("eE") == word.npos;
    if (decimals > 0 && is_plain) {
      stamps_s.push_back(FiniteNumber(Concat(word, "e-", decimals)));
    } else {
      stamps_s.push_back(FiniteNumber(word) * std::pow(10, -decimals));
    }
  }
  return stamps_s;
}

// Uses Padded() if it makes the intervals more regular.
std::vector<std::string> PadFractions(const std::vector<std::string>& words,
                                      const std::string& source,
                                      std::vector<std::string>* warnings) {
  const std::vector<std::string> padded = Padded(words);
  if (padded.empty() ||
      Irregularity(InSeconds(padded, 0)) >= 0.5 * Irregularity(InSeconds(words, 0))) {
    return words;
  }
  const auto [from, to] = std::mismatch(words.begin(), words.end(), padded.begin());
  warnings->push_back(Concat(source, ": the fractions of the timestamps have no leading zeros, ",
                             *from, " is read as ", *to));
  return padded;
}

// True if the time ranges of two lists have a common time.
bool Overlap(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return false;
  const auto [a_begin, a_end] = std::minmax_element(a.begin(), a.end());
  const auto [b_begin, b_end] = std::minmax_element(b.begin(), b.end());
  return *a_begin <= *b_end && *b_begin <= *a_end;
}

}  // namespace

const char* TimeUnitName(int decimals) {
  return decimals == 0 ? "s" : (decimals == 3 ? "ms" : (decimals == 6 ? "us" : "ns"));
}

std::optional<int> DetectTimeUnit(const std::vector<double>& stamps) {
  constexpr double kLeast_s = 0.008, kMost_s = 3;  // interval of frames: 125 Hz to 0.33 Hz
  const std::vector<double> intervals = Intervals(stamps);
  if (intervals.empty()) return std::nullopt;
  const double usual = MedianOf(intervals);
  for (const int decimals : kUnits) {
    const double usual_s = usual * std::pow(10, -decimals);
    if (usual_s < kLeast_s || usual_s >= kMost_s) continue;
    if (decimals == 3 && AreFrameNumbers(stamps, intervals, usual)) return std::nullopt;
    return decimals;
  }
  return std::nullopt;
}

Times ParseTimes(const std::vector<std::string>& words, const std::string& source,
                 std::vector<std::string>* warnings) {
  const std::vector<std::string> padded = PadFractions(words, source, warnings);
  const std::vector<double> numbers = InSeconds(padded, 0);
  const int decimals = DetectTimeUnit(numbers).value_or(0);
  if (decimals == 0) return {numbers, 0};
  warnings->push_back(Concat(source, ": timestamps like ", words[0], " are in ",
                             TimeUnitName(decimals), " by their intervals (median ",
                             MedianOf(Intervals(numbers)), "), they are converted to s"));
  return {InSeconds(padded, decimals), decimals};
}

std::vector<double> ParseTruthTimes(const std::vector<std::string>& words, const Times& images,
                                    const std::string& source, std::vector<std::string>* warnings) {
  const std::vector<std::string> padded = PadFractions(words, source, warnings);
  std::vector<double> stamps_s = InSeconds(padded, 0);
  if (images.decimals == 0 || Overlap(stamps_s, images.stamps_s)) return stamps_s;
  std::vector<double> converted_s = InSeconds(padded, images.decimals);
  if (!Overlap(converted_s, images.stamps_s)) return stamps_s;
  warnings->push_back(Concat(source, ": timestamps are in ", TimeUnitName(images.decimals),
                             ", like those of the images"));
  return converted_s;
}

std::vector<std::size_t> FindClockStarts(const std::vector<double>& stamps_s) {
  constexpr double kMinBack = 5;       // intervals
  constexpr std::size_t kMinPart = 5;  // frames per part
  if (stamps_s.size() < 2) return {0};
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < stamps_s.size(); ++i)
    steps_s.push_back(std::abs(stamps_s[i] - stamps_s[i - 1]));
  const double least_s = kMinBack * MedianOf(steps_s);
  struct Part {
    double first_s = 0, last_s = 0;
    std::size_t size = 1;
  };
  std::vector<std::size_t> starts = {0};
  std::vector<Part> parts = {{stamps_s[0], stamps_s[0]}};
  for (std::size_t i = 1; i < stamps_s.size(); ++i) {
    if (stamps_s[i] < stamps_s[i - 1] - least_s) {
      starts.push_back(i);
      parts.push_back({stamps_s[i], stamps_s[i], 0});
    }
    Part& part = parts.back();
    part.first_s = std::min(part.first_s, stamps_s[i]);
    part.last_s = std::max(part.last_s, stamps_s[i]);
    ++part.size;
  }
  std::sort(parts.begin(), parts.end(),
            [](const Part& a, const Part& b) { return a.first_s < b.first_s; });
  bool overlap = false, apart = false;
  std::size_t smallest = parts[0].size;
  for (std::size_t k = 1; k < parts.size(); ++k) {
    const double gap_s = parts[k].first_s - parts[k - 1].last_s;
    overlap = overlap || gap_s <= 0;
    apart = apart || gap_s > least_s;
    smallest = std::min(smallest, parts[k].size);
  }
  if (overlap && stamps_s.size() >= kMinPart * starts.size()) return starts;
  if (apart && smallest >= kMinPart) return starts;
  return {0};
}

}  // namespace surfit
