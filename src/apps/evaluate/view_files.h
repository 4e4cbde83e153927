#pragma once

#include <string>
#include <vector>

#include "apps/evaluate/view_evaluation.h"
#include "surfit/core/image.h"

namespace surfit {

// Evaluated view with its images, which have equal sizes.
struct ComparedView {
  EvaluatedView view;
  Image<Rgb8> frame, drawn;
};

// Keeps the `most` views with the lowest psnr_covered_db. Not thread-safe.
class WorstViews {
 public:
  explicit WorstViews(int most) : most_(most) {}

  void Offer(ComparedView view);
  // Writes the pictures into the output folder. Returns the path of the first picture, or an empty
  // string. Throws InputError with the file name.
  std::string Write(const std::string& folder) const;

 private:
  int most_;
  std::vector<ComparedView> views_;  // worst first
};

// Writes views.json (means) and views.csv (all views). Throws InputError with the file name.
void WriteViewFiles(const ViewEvaluation& evaluation, const std::string& folder);

}  // namespace surfit
