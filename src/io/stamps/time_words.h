#pragma once

#include <optional>
#include <string>
#include <vector>

namespace surfit {

// Units of timestamps: stamps are in 10^-decimals s. 0: s, 3: ms, 6: us, 9: ns.
const char* TimeUnitName(int decimals);

// Detects the unit of the timestamps of one camera by their median interval: the only unit in which
// it is between 8 ms and 3 s. Returns std::nullopt if there is no such unit, or fewer than two
// different timestamps. Small integers in equal or irregular steps are frame numbers, and have no
// unit either.
std::optional<int> DetectTimeUnit(const std::vector<double>& stamps);

// Timestamps of one list of images.
struct Times {
  std::vector<double> stamps_s;
  int decimals = 0;  // unit of the words
};

// Parses the timestamps of one list of images, in the order of the list:
// - Words without leading zeros of the fraction are detected, because seconds and nanoseconds were
//   written as two integers: 12.5000000 is 12.005 s.
// - The unit is that of DetectTimeUnit(), and s without one.
//
// Both are added to `warnings`, with `source` as the name of the list. The words must be numbers:
// throws InputError for others.
Times ParseTimes(const std::vector<std::string>& words, const std::string& source,
                 std::vector<std::string>* warnings);

// Parses the timestamps of ground truth. Detects missing zeros like ParseTimes(). The unit is s.
// The unit of the images is used if only then timestamps are in the time of the images. It is added
// to `warnings`.
std::vector<double> ParseTruthTimes(const std::vector<std::string>& words, const Times& images,
                                    const std::string& source, std::vector<std::string>* warnings);

// Splits the timestamps of a list, in its order, where the clock starts again. Returns the first
// index of each part, {0} for one part. An unsorted list is one part. Its parts do not overlap in
// time, or it goes back by a few intervals only.
std::vector<std::size_t> FindClockStarts(const std::vector<double>& stamps_s);

}  // namespace surfit
