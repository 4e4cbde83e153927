#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// One line of a table of text: its columns, and its place for messages.
struct TextRow {
  std::string place;  // "file:line"
  std::vector<std::string> columns;
};

// Calls with each line of a text file that is neither empty nor a comment (#); columns are
// separated by spaces, tabs or commas. Throws InputError naming the file if it cannot be read.
void ForEachTextRow(const std::string& path, const std::function<void(const TextRow&)>& call);

// The same lines, for small files: they take many times the file's size.
std::vector<TextRow> ReadTextRows(const std::string& path);

// The word as a finite number. Throws InputError naming it.
double FiniteNumber(std::string_view word);

// The same. Throws InputError naming place and text.
double ParseNumber(const std::string& text, const std::string& place);

// The rigid transform tx ty tz qx qy qz qw, m. Throws InputError unless the quaternion has length 1
// (to 1 %, as files of few decimals have it), and no coordinate is beyond a million kilometres, of
// which the squares that errors are made of could not be told apart.
Rigid3d RigidFromNumbers(const double* numbers);

// The rigid transform of a 4 x 4 matrix. Throws InputError naming the place unless its upper left
// is a rotation (to 1 %), and its translation as above.
Rigid3d RigidFromMatrix(const Eigen::Matrix4d& matrix, const std::string& place);

// The rigid transform in the rows [first, first + 4) of a text file, a 4 x 4 matrix. Throws
// InputError naming the place unless they are four rows of four finite numbers, or as
// RigidFromMatrix().
Rigid3d ParseRigid(const std::vector<TextRow>& rows, std::size_t first, const std::string& path);

using Words = std::vector<std::string_view>;

// The words of a line, which blanks, tabs and a carriage return separate.
Words SplitWords(std::string_view line);

// Throws InputError naming the word unless it is an integer from 0.
std::int64_t ParseCount(std::string_view word);

}  // namespace surfit
