#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// Non-empty line of a text file.
struct TextRow {
  std::string place;  // "file:line", for error messages
  std::vector<std::string> columns;
};

// Calls `call` for each line of a text file, except empty lines and comments (first character #).
// Columns are separated by spaces, tabs or commas. Throws InputError with the path if the file
// cannot be read.
void ForEachTextRow(const std::string& path, const std::function<void(const TextRow&)>& call);

// Returns the rows of ForEachTextRow(). They take many times the memory of the file.
std::vector<TextRow> ReadTextRows(const std::string& path);

// Removes the byte order mark of UTF-8, which Windows editors write at the start of a file.
std::string_view WithoutByteOrderMark(std::string_view file);

// Removes the plus sign of a number, which std::from_chars() rejects. "+-1" is unchanged.
std::string_view WithoutPlus(std::string_view word);

// Parses a finite number, with or without a sign. Throws InputError with the word.
double FiniteNumber(std::string_view word);

// FiniteNumber() with the place in the error message.
double ParseNumber(const std::string& text, const std::string& place);

// Rigid transform from tx ty tz qx qy qz qw, translation in m. Normalises the quaternion. Throws
// InputError if its norm differs from 1 by more than 1 %, or a coordinate is NaN or exceeds 1e9 m
// (squared errors would lose all precision).
Rigid3d RigidFromNumbers(const double* numbers);

// Rigid transform from a 4 x 4 matrix, translation in m. Throws InputError with the place unless
// the upper left block is a rotation (to 1 %) and all coordinates are within 1e9 m. The last row is
// not checked.
Rigid3d RigidFromMatrix(const Eigen::Matrix4d& matrix, const std::string& place);

// Parses a number that may be nan or inf. Throws InputError with the word.
double AnyNumber(std::string_view word);

// Rigid transform of a text file, or the reason why its numbers are no rigid transform.
struct ParsedRigid {
  std::optional<Rigid3d> transform;  // std::nullopt: see `error`
  std::string error;
};

// Parses 16 words, a row-major 4 x 4 matrix. Throws InputError with the place for a word that is
// not a number; nan and inf are numbers.
ParsedRigid ParseRigid(const std::vector<std::string>& words, const std::string& place);

// Parses the rows [first, first + 4). Throws InputError with the path or the place unless these are
// four rows of four numbers.
ParsedRigid ParseRigid(const std::vector<TextRow>& rows, std::size_t first,
                       const std::string& path);

using Words = std::vector<std::string_view>;

// Splits a line at spaces, tabs and carriage returns. The words are views of `line`. Empty for a
// blank line.
Words SplitWords(std::string_view line);

// Parses an integer of at least 0. Throws InputError with the word.
std::int64_t ParseCount(std::string_view word);

}  // namespace surfit
