#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/files.h"
#include "io/files/text.h"
#include "surfit/core/error.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Returns read(json) for a JSON file. JSON errors become InputErrors with the path.
template <typename Read>
auto WithJsonFile(const std::string& path, const Read& read) {
  try {
    return read(nlohmann::json::parse(ReadJsonText(path)));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, ": ", error.what());
  }
}

// Number of a field. Throws InputError with the place, the key and the rule unless it exists.
double JsonNumber(const nlohmann::json& object, const std::string& key, const std::string& place);

// Numbers of an array. Throws InputError with the place unless it has `count` numbers.
std::vector<double> JsonNumbers(const nlohmann::json& array, std::size_t count,
                                const std::string& place);

// Image size of the fields for width and height: integers from 1 to 16384.
void SetJsonSize(const nlohmann::json& object, const char* width, const char* height,
                 const std::string& place, PinholeCamera* camera);

// Rigid transform of a row-major 3 x 4 matrix, or the reason why it is none.
ParsedRigid RigidFromRows(const std::array<double, 12>& rows, const std::string& place);

}  // namespace surfit
