#pragma once

#include <string>
#include <vector>

namespace surfit {

// One line of a table of text: its columns, and its place for messages.
struct TextRow {
  std::string place;  // "file:line"
  std::vector<std::string> columns;
};

// The lines of a text file that are neither empty nor comments (#); columns are separated by
// spaces, tabs or commas. Throws InputError naming the file if it cannot be read.
std::vector<TextRow> ReadTextRows(const std::string& path);

// The column as a finite number. Throws InputError naming place and text.
double ParseNumber(const std::string& text, const std::string& place);

}  // namespace surfit
