#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Rows of dots over a logarithmic axis, with the values in figures beside them.
struct DotChart {
  struct Row {
    std::string label;
    std::vector<std::optional<double>> values;  // one of each series; none where it has none
  };
  // Rows under a common heading.
  struct Group {
    std::string heading;
    std::vector<Row> rows;
  };

  std::string title, x_label;
  std::vector<std::string> series;
  std::vector<Group> groups;
};

Image<Rgb8> DrawDotChart(const DotChart& chart);

}  // namespace surfit
