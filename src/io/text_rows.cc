#include "io/text_rows.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "core/read_file.h"
#include "surfit/core/error.h"

namespace surfit {

std::vector<TextRow> ReadTextRows(const std::string& path) {
  std::istringstream text(ReadFile(path));
  std::vector<TextRow> rows;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    for (char& c : line) {
      if (c == ',') c = ' ';
    }
    TextRow row{Concat(path, ":", number), {}};
    std::istringstream columns(line);
    for (std::string column; columns >> column;) row.columns.push_back(column);
    if (!row.columns.empty() && row.columns[0][0] != '#') rows.push_back(std::move(row));
  }
  return rows;
}

double ParseNumber(const std::string& text, const std::string& place) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(Concat(place, ": '", text, "' is not a finite number"));
  return value;
}

}  // namespace surfit
