#pragma once

#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Values at 0, 1, 2, ...; of those that are not positive nothing is drawn.
struct LineSeries {
  std::string name;
  std::vector<double> values;
};

struct LinePanel {
  std::string title;
  std::vector<LineSeries> series;
};

// Panels of lines over a logarithmic axis, four in a row, with one legend: a name has one colour in
// all panels. Series that lie upon each other all show: the earlier ones are wider.
Image<Rgb8> DrawLinePanels(const std::vector<LinePanel>& panels, const std::string& x_label,
                           const std::string& y_label);

}  // namespace surfit
