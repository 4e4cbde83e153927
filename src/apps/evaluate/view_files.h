#pragma once

#include <string>
#include <vector>

#include "apps/evaluate/view_evaluation.h"
#include "surfit/core/image.h"

namespace surfit {

// A view that was judged, and what it was judged by.
struct ComparedView {
  JudgedView view;
  Image<Rgb8> frame, drawn;
};

// Keeps those of least psnr_covered_db.
class WorstViews {
 public:
  explicit WorstViews(int most) : most_(most) {}

  void Offer(ComparedView view);
  // Writes their pictures into the folder, and returns the path of the first one, empty without.
  // Throws InputError naming the file.
  std::string Write(const std::string& folder) const;

 private:
  int most_;
  std::vector<ComparedView> views_;  // the worst first
};

// Writes views.json and views.csv. Throws InputError naming the file.
void WriteViewFiles(const ViewEvaluation& evaluation, const std::string& folder);

}  // namespace surfit
