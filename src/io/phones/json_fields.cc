#include "io/phones/json_fields.h"

#include <cmath>

namespace surfit {

double JsonNumber(const nlohmann::json& object, const std::string& key, const std::string& place) {
  ThrowIf(!object.is_object() || !object.contains(key), place, ": ", key,
          " is missing, must be a number");
  const nlohmann::json& value = object.at(key);
  ThrowIf(!value.is_number(), place, ": ", key, " is ", value.dump(), ", must be a number");
  return value.get<double>();
}

std::vector<double> JsonNumbers(const nlohmann::json& array, std::size_t count,
                                const std::string& place) {
  ThrowIf(!array.is_array() || array.size() != count, place, " has ",
          array.is_array() ? array.size() : 0, " numbers, must have ", count);
  std::vector<double> numbers;
  for (const nlohmann::json& value : array) {
    ThrowIf(!value.is_number(), place, " has ", value.dump(), ", must have numbers");
    numbers.push_back(value.get<double>());
  }
  return numbers;
}

void SetJsonSize(const nlohmann::json& object, const char* width, const char* height,
                 const std::string& place, PinholeCamera* camera) {
  const auto side = [&](const char* key) {
    const double value = JsonNumber(object, key, place);
    ThrowIf(!(value >= 1 && value <= 16384) || value != std::floor(value), place, ": ", key, " is ",
            value, ", must be an integer from 1 to 16384");
    return static_cast<int>(value);
  };
  camera->width = side(width);
  camera->height = side(height);
}

ParsedRigid RigidFromRows(const std::array<double, 12>& rows, const std::string& place) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = rows[i];
  try {
    return {RigidFromMatrix(matrix, place), ""};
  } catch (const InputError& error) {
    return {std::nullopt, error.what()};
  }
}

}  // namespace surfit
