#include "io/phones/csv_rows.h"

#include "core/files.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

std::string Trimmed(std::string_view cell) {
  constexpr std::string_view kSpaces = " \t\r";
  const std::size_t first = cell.find_first_not_of(kSpaces);
  if (first == cell.npos) return "";
  return std::string(cell.substr(first, cell.find_last_not_of(kSpaces) + 1 - first));
}

std::vector<std::string> CellsOf(std::string_view line) {
  std::vector<std::string> cells;
  for (std::size_t comma = 0; comma != line.npos;) {
    comma = line.find(',');
    cells.push_back(Trimmed(line.substr(0, comma)));
    if (comma != line.npos) line.remove_prefix(comma + 1);
  }
  return cells;
}

// Lines with a text, without names of columns.
CsvTable LinesOf(const std::string& path) {
  CsvTable table;
  table.path = path;
  const std::string text = ReadFile(path);
  int number = 0;
  for (std::string_view rest = WithoutByteOrderMark(text); !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    ++number;
    if (Trimmed(line).empty()) continue;
    table.places.push_back(Concat(path, ":", number));
    table.rows.push_back(CellsOf(line));
  }
  return table;
}

double CellNumber(const std::string& cell, const std::string& place, const std::string& column) {
  try {
    return FiniteNumber(cell);
  } catch (const InputError&) {
    throw InputError(place, ": ", column, " is '", cell, "', must be a finite number");
  }
}

}  // namespace

double CsvTable::Number(std::size_t row, const std::string& column) const {
  const std::size_t index = columns.at(column);
  ThrowIf(index >= rows[row].size(), places[row], " has ", rows[row].size(), " columns, must have ",
          index + 1, " or more: ", column, " is missing");
  return CellNumber(rows[row][index], places[row], column);
}

CsvTable ReadCsv(const std::string& path, const std::vector<std::string>& required) {
  CsvTable table = LinesOf(path);
  ThrowIf(table.rows.empty(), path, " is empty, must begin with the names of its columns");
  for (std::size_t i = 0; i < table.rows[0].size(); ++i) table.columns[table.rows[0][i]] = i;
  table.rows.erase(table.rows.begin());
  table.places.erase(table.places.begin());
  for (const std::string& column : required)
    ThrowIf(!table.Has(column), path, ": its first line has no column ", column);
  return table;
}

std::vector<double> ReadCsvMatrix(const std::string& path, std::size_t height, std::size_t width) {
  const CsvTable table = LinesOf(path);
  ThrowIf(table.rows.size() != height, path, " has ", table.rows.size(), " rows, must have ",
          height);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < height; ++i) {
    ThrowIf(table.rows[i].size() != width, table.places[i], " has ", table.rows[i].size(),
            " columns, must have ", width);
    for (std::size_t k = 0; k < width; ++k)
      numbers.push_back(CellNumber(table.rows[i][k], table.places[i], Concat("column ", k + 1)));
  }
  return numbers;
}

}  // namespace surfit
