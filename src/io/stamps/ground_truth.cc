#include "io/stamps/ground_truth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit {
namespace {

ParsedRigid ParseTumPose(const TextRow& row) {
  std::array<double, 7> numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string& word = row.columns[i + 1];
    numbers[i] = WithContext(row.place, [&] { return AnyNumber(word); });
    if (!std::isfinite(numbers[i]))
      return {std::nullopt, Concat(row.place, ": '", word, "' is not a finite number")};
  }
  try {
    return {RigidFromNumbers(numbers.data()), ""};
  } catch (const InputError& error) {
    return {std::nullopt, Concat(row.place, ": ", error.what())};
  }
}

}  // namespace

void GroundTruthPoses::Add(double stamp_s, const ParsedRigid& parsed) {
  if (parsed.transform) {
    poses_.push_back({stamp_s, *parsed.transform});
  } else if (invalid_++ == 0) {
    first_error_ = parsed.error;
  }
}

Trajectory GroundTruthPoses::Take(std::vector<std::string>* warnings) {
  const std::size_t count = poses_.size() + static_cast<std::size_t>(invalid_ + without_frame_);
  if (invalid_ > 0) {
    warnings->push_back(Concat(source_, ": ", invalid_, " of ", count,
                               " ground-truth poses are invalid and left out (", first_error_,
                               "), their frames have no ground truth"));
  }
  if (without_frame_ > 0) {
    warnings->push_back(Concat(source_, ": ", without_frame_, " of ", count,
                               " ground-truth poses belong to no frame"));
  }
  std::stable_sort(poses_.begin(), poses_.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_s < b.stamp_s;
  });
  return std::move(poses_);
}

Trajectory ReadGroundTruth(const std::string& path, const Times& images,
                           std::vector<std::string>* warnings) {
  std::vector<std::string> words;
  std::vector<ParsedRigid> parsed;
  ForEachTextRow(path, [&](const TextRow& row) {
    ThrowIf(row.columns.size() != 8, row.place, ": ", row.columns.size(), " columns, must be 8");
    ParseNumber(row.columns[0], row.place);
    words.push_back(row.columns[0]);
    parsed.push_back(ParseTumPose(row));
  });
  const std::vector<double> stamps_s = ParseTruthTimes(words, images, path, warnings);
  GroundTruthPoses poses(path);
  for (std::size_t i = 0; i < parsed.size(); ++i) poses.Add(stamps_s[i], parsed[i]);
  return poses.Take(warnings);
}

}  // namespace surfit
