#pragma once

#include <string>
#include <vector>

namespace surfit::tools {

// Lines of columns that are as wide as their widest cell: the first `left_columns` of them begin
// together, the others end together. All rows have the same number of cells.
std::string TextTable(const std::vector<std::vector<std::string>>& rows, std::size_t left_columns);

}  // namespace surfit::tools
