#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// Shares from 0 to 1, row by row; empty where there is none.
using ShareTable = std::vector<std::vector<std::optional<double>>>;

// Small tables of shares, each cell in its colour with its percent, in the rows and columns of a
// large one. All small tables have the same labels.
struct ShareTables {
  std::vector<std::string> row_titles, column_titles;
  std::string title, cell_rows_label, cell_columns_label;
  std::vector<std::string> cell_row_labels, cell_column_labels;
  // By row and column; an empty one is left out.
  std::vector<std::vector<ShareTable>> tables;
};

Image<Rgb8> DrawShareTables(const ShareTables& tables);

}  // namespace surfit
