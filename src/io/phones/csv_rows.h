#pragma once

#include <map>
#include <string>
#include <vector>

namespace surfit {

// Table of comma-separated values. Cells may be empty.
struct CsvTable {
  std::string path;
  std::map<std::string, std::size_t> columns;  // by name, from the first line
  std::vector<std::string> places;             // "file:line" of each row
  std::vector<std::vector<std::string>> rows;  // cells without spaces around them

  bool Has(const std::string& column) const { return columns.count(column) > 0; }
  // Finite number of a cell. Throws InputError with the place, the column and the rule.
  double Number(std::size_t row, const std::string& column) const;
};

// Reads the table. Empty lines are skipped. Throws InputError that names the path and the column
// unless all columns of `required` exist.
CsvTable ReadCsv(const std::string& path, const std::vector<std::string>& required);

// Reads `height` lines of `width` numbers without names. Throws InputError with the line and the
// rule.
std::vector<double> ReadCsvMatrix(const std::string& path, std::size_t height, std::size_t width);

}  // namespace surfit
