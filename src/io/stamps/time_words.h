#pragma once

#include <optional>
#include <string>
#include <vector>

namespace surfit {

// Name of the unit 10^-decimals s. 0: s, 3: ms, 6: us, 9: ns.
const char* TimeUnitName(int decimals);

// Detects the unit of the timestamps of one camera by their median interval: the only unit in which
// it is between 8 ms and 3 s. Returns std::nullopt if there is no such unit, or fewer than two
// different timestamps. Also returns std::nullopt for frame numbers: integers below 1e11 whose
// steps are irregular or multiples of the smallest step.
std::optional<int> DetectTimeUnit(const std::vector<double>& stamps);

// Timestamps of one list of images.
struct Times {
  std::vector<double> stamps_s;
  int decimals = 0;  // unit of the words: 10^-decimals s
};

// Parses the timestamps of one list of images, in the order of the list:
// - Missing leading zeros of fractions are added if intervals become more regular: 12.5000000 is
//   12.005 s if seconds and nanoseconds were written as two integers.
// - The unit is detected by DetectTimeUnit(). If that fails, the unit is s.
//
// Adds a warning for added zeros and for another unit than s, with `source` as the name of the
// list. Throws InputError for words that are not finite numbers.
Times ParseTimes(const std::vector<std::string>& words, const std::string& source,
                 std::vector<std::string>* warnings);

// Parses the timestamps of ground truth. Adds missing zeros like ParseTimes(). The unit is s. If
// the time ranges of poses and images overlap only in the unit of the images, uses this unit and
// adds a warning.
std::vector<double> ParseTruthTimes(const std::vector<std::string>& words, const Times& images,
                                    const std::string& source, std::vector<std::string>* warnings);

// Finds restarts of the clock in a list of timestamps. Returns the first index of each part, {0}
// for one part, and {0} for an empty list. A restart is a step back of more than five median
// intervals. Lists without these properties are unsorted, and are one part:
// - Two parts overlap in time, and the parts have at least five timestamps (mean).
// - Two parts are more than five median intervals apart, and each part has at least five
// timestamps.
std::vector<std::size_t> FindClockStarts(const std::vector<double>& stamps_s);

}  // namespace surfit
