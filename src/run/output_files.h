#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Keys stay in the order in which they are set.
using Json = nlohmann::ordered_json;

// Makes the output folder if it is missing, and removes a former run's files from it.
// Throws InputError naming the folder or file if that fails.
void PrepareOutputFolder(const std::string& folder, const std::vector<std::string>& former_files);

// Writes a JSON file, indented unless indent is -1. What is no UTF-8 (a file's name may be
// anything) is replaced. Throws InputError naming the file.
void WriteJson(const Json& json, const std::string& path, int indent = 2);

// Width, height, fx, fy, cx and cy.
Json CameraToJson(const PinholeCamera& camera);
PinholeCamera CameraFromJson(const Json& json);

}  // namespace surfit
