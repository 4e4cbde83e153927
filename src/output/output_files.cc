#include "output/output_files.h"

#include <cmath>

#include "core/files.h"
#include "core/shared_options.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {

Json ReadJson(const std::string& path) {
  Json json;
  try {
    json = Json::parse(ReadJsonText(path));
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": not valid JSON: ", error.what()));
  }
  if (!json.is_object()) throw InputError(Concat(path, " must be a JSON object"));
  return json;
}

void WriteJson(const Json& json, const std::string& path, int indent) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << json.dump(indent, ' ', false, Json::error_handler_t::replace) << '\n';
  });
}

namespace {

// Quotes texts with commas, quotes or line breaks (RFC 4180).
std::string CsvCell(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    const double number = value;
    return std::isnan(number) ? "" : number > 0 ? "inf" : "-inf";
  }
  if (!value.is_string()) return value.dump();
  const std::string text = value;
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

void WriteCsv(const Json& rows, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    if (rows.empty()) return;
    const char* separator = "";
    for (const auto& [key, value] : rows.front().items()) {
      file << separator << key;
      separator = ",";
    }
    file << '\n';
    for (const Json& row : rows) {
      separator = "";
      for (const auto& [key, value] : row.items()) {
        file << separator << CsvCell(value);
        separator = ",";
      }
      file << '\n';
    }
  });
}

Json ToJson(const Rigid3d& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json CameraToJson(const PinholeCamera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

PinholeCamera CameraFromJson(const Json& json) {
  PinholeCamera camera;
  camera.width = json.at("width");
  camera.height = json.at("height");
  camera.fx = json.at("fx");
  camera.fy = json.at("fy");
  camera.cx = json.at("cx");
  camera.cy = json.at("cy");
  camera.Validate("camera");
  return camera;
}

namespace {

using Json = nlohmann::ordered_json;

class Writer final : public OptionVisitor {
 public:
  explicit Writer(Json* json) : path_{json} {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    Json& json = (*path_.back())[option.name];
    std::visit(
        [&](const auto* field) {
          if constexpr (std::is_same_v<decltype(field), const OptionText*>) {
            json = field->Get();
          } else {
            json = *field;
          }
        },
        value);
  }
  bool Enter(const Option& part, const std::type_info&, void*) override {
    path_.push_back(&(*path_.back())[part.name]);
    return true;
  }
  void Leave() override { path_.pop_back(); }

  std::vector<Json*> path_;
};

class Reader final : public OptionVisitor {
 public:
  explicit Reader(const Json* json) : path_{json} {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    const Json& json = Member(option.name);
    std::visit(
        [&](auto* field) {
          if constexpr (std::is_same_v<decltype(field), OptionText*>) {
            SetText(option.name, json.get<std::string>(), field);
          } else {
            json.get_to(*field);
          }
        },
        value);
  }
  bool Enter(const Option& part, const std::type_info&, void*) override {
    path_.push_back(&Member(part.name));
    return true;
  }
  void Leave() override { path_.pop_back(); }

  // Files of version 0.1 use old option names.
  const Json& Member(const std::string& name) const {
    const Json& json = *path_.back();
    return json.contains(name) ? json.at(name) : json.at(OldName(name));
  }

  std::vector<const Json*> path_;
};

}  // namespace

Json TableToJson(const OptionTable& table) {
  Json json = Json::object();
  Writer writer(&json);
  table(writer);
  return json;
}

void ReadTable(const Json& json, const OptionTable& table) {
  Reader reader(&json);
  table(reader);
}

namespace {

// Sum of the given and the estimated field, as a function of the rays of the estimated camera.
InverseDepthField Combined(const DepthCalibration& given, const DepthCalibration& found) {
  const PinholeCamera &a = given.camera, &b = found.camera;
  InverseDepthField sum =
      given.field.Substituted(b.fx / a.fx, (b.cx - a.cx) / a.fx, b.fy / a.fy, (b.cy - a.cy) / a.fy);
  for (std::size_t i = 0; i < InverseDepthField::kSize; ++i) {
    sum.coefficients[i] += found.field.coefficients[i];
  }
  return sum;
}

// Camera of the full-size images.
RgbdCamera Calibrated(RgbdCamera camera, const DepthCalibration& given,
                      const DepthCalibration& found) {
  const bool mirrored = camera.depth.fy < 0;
  if (mirrored) camera = Mirrored(camera);
  PinholeCamera& depth = camera.depth;
  const double downsample = depth.fx / given.camera.fx;
  depth.fx = found.camera.fx * downsample;
  depth.fy = found.camera.fy * downsample;
  depth.cx = found.camera.cx * downsample;
  depth.cy = found.camera.cy * downsample;
  camera.readout_s = found.readout_s;
  return mirrored ? Mirrored(camera) : camera;
}

}  // namespace

DepthCalibration CalibrationOfRawDepth(const SequenceInfo& info,
                                       const InverseDepthField& given_field,
                                       const DepthCalibration& found) {
  return {found.camera, Combined({info.pinhole, given_field}, found), found.readout_s};
}

void WriteEstimatedCamera(const SequenceInfo& info, const InverseDepthField& given_field,
                          const DepthCalibration& found, const std::string& path) {
  const DepthCalibration given = {info.pinhole, given_field};
  const InverseDepthField field = Combined(given, found);
  WriteCameraYaml(Calibrated(info.camera, given, found), path,
                  info.mirrored ? Mirrored(field) : field);
}

Json ToJson(const DepthCalibration& calibration) {
  const PinholeCamera& c = calibration.camera;
  return {{"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"inverse_depth_field", calibration.field.coefficients},
          {"readout_s", calibration.readout_s}};
}

Json CalibrationSigmasToJson(const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0) return nullptr;
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const double* const field = sigma.data() + 4;
  const double* const readout = field + InverseDepthField::kSize;
  return {{"fx", sigma[0]},
          {"fy", sigma[1]},
          {"cx", sigma[2]},
          {"cy", sigma[3]},
          {"inverse_depth_field", std::vector<double>(field, readout)},
          {"readout_s", *readout}};
}

}  // namespace surfit
