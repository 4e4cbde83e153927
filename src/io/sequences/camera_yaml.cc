#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "core/files.h"
#include "core/shared_options.h"
#include "io/files/text.h"
#include "io/files/yaml.h"
#include "io/lenses/lens_fit.h"
#include "io/sequences/folder.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

// The node may be missing. Its name is for error messages.
class Node {
 public:
  Node(const YamlNode* node, const std::string& name) : node_(node), name_(name) {}

  bool Exists() const { return node_ != nullptr && node_->kind != YamlNode::Kind::kNothing; }
  Node operator[](const std::string& key) const {
    return Node(node_ == nullptr ? nullptr : node_->Find(key), name_ + ": " + key);
  }

  void RequireKeysAmong(const std::vector<std::string>& known) const {
    ThrowIf(!Exists() || node_->kind != YamlNode::Kind::kMap, name_,
            " must be a map of keys to values");
    for (const std::string& key : node_->keys) {
      ThrowIf(std::find(known.begin(), known.end(), key) == known.end(), name_, ": '", key,
              "' is not a known key");
    }
  }
  double Number() const {
    ThrowIf(!Exists(), name_, " is missing");
    ThrowIf(node_->kind != YamlNode::Kind::kScalar, name_, " must be a number");
    try {
      return FiniteNumber(node_->scalar);
    } catch (const InputError& error) {
      throw InputError(name_, " must be a number: ", error.what());
    }
  }
  int Integer() const {
    const double number = Number();
    ThrowIf(number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max(),
            name_, " must be an integer");
    return static_cast<int>(number);
  }
  std::string Text() const {
    ThrowIf(!Exists() || node_->kind != YamlNode::Kind::kScalar, name_, " must be a word");
    return node_->scalar;
  }
  std::vector<double> List() const {
    ThrowIf(!Exists() || node_->kind != YamlNode::Kind::kList, name_, " must be a list of numbers");
    std::vector<double> numbers;
    for (const YamlNode& value : node_->values) numbers.push_back(Node(&value, name_).Number());
    return numbers;
  }
  const std::string& name() const { return name_; }
  template <std::size_t kSize>
  std::array<double, kSize> Numbers() const {
    ThrowIf(!Exists() || node_->kind != YamlNode::Kind::kList || node_->values.size() != kSize,
            name_, " must be a list of ", kSize, " numbers");
    std::array<double, kSize> numbers;
    for (std::size_t i = 0; i < kSize; ++i) numbers[i] = Node(&node_->values[i], name_).Number();
    return numbers;
  }

 private:
  const YamlNode* node_;
  std::string name_;
};

// Collects the fields of an option table by name. All fields must be doubles.
class Numbers : public OptionVisitor {
 public:
  std::vector<std::pair<std::string, double*>> all;

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    all.emplace_back(option.name, std::get<double*>(value));
  }
};

template <typename Fields>
Numbers NumbersOf(Fields* fields) {
  Numbers numbers;
  fields->Visit(numbers);
  return numbers;
}

CalibrationPrior ReadPrior(const Node& node) {
  CalibrationPrior prior;
  std::vector<std::string> names;
  const Numbers numbers = NumbersOf(&prior);
  // Files of version 0.1 have old parameter names.
  for (const auto& [name, number] : numbers.all) {
    names.push_back(name);
    if (OldName(name) != name) names.push_back(OldName(name));
  }
  node.RequireKeysAmong(names);
  for (const auto& [name, number] : numbers.all) {
    const Node present = node[name], old = node[OldName(name)];
    if (present.Exists() || old.Exists()) *number = (present.Exists() ? present : old).Number();
  }
  return prior;
}

// Five coefficients of PinholeCamera, or of another model that FitDistortion() approximates.
std::array<double, 5> ReadDistortion(const Node& node, const PinholeCamera& camera) {
  const Node distortion = node["distortion"], model = node["distortion_model"];
  const std::vector<double> numbers = distortion.List();
  const std::string named = model.Exists() ? model.Text() : "";
  if (named == "plumb_bob" || (named.empty() && numbers.size() == 5))
    return distortion.Numbers<5>();
  ThrowIf(named.empty() && numbers.size() != 8 && numbers.size() != 12, distortion.name(), " has ",
          numbers.size(),
          " numbers, must have 5 (plumb_bob), 8 or 12 (rational), or 4 with distortion_model: "
          "fisheye");
  camera.Validate(node.name());
  return FitDistortion(named.empty() ? "rational" : named, numbers, camera, node.name());
}

PinholeCamera ReadPinhole(const Node& node) {
  node.RequireKeysAmong(
      {"width", "height", "fx", "fy", "cx", "cy", "distortion", "distortion_model"});
  PinholeCamera camera;
  camera.width = node["width"].Integer();
  camera.height = node["height"].Integer();
  camera.fx = node["fx"].Number();
  camera.fy = node["fy"].Number();
  camera.cx = node["cx"].Number();
  camera.cy = node["cy"].Number();
  if (node["distortion"].Exists()) camera.distortion = ReadDistortion(node, camera);
  return camera;
}

Disparity ReadDisparity(const Node& node, const std::string& name) {
  node.RequireKeysAmong({"focal_px", "baseline_m", "counts_per_px", "count_at_infinity"});
  Disparity disparity;
  disparity.focal_px = node["focal_px"].Number();
  disparity.baseline_m = node["baseline_m"].Number();
  if (node["counts_per_px"].Exists()) disparity.counts_per_px = node["counts_per_px"].Number();
  if (node["count_at_infinity"].Exists())
    disparity.count_at_infinity = node["count_at_infinity"].Number();
  disparity.Validate(name);
  return disparity;
}

Rigid3d ReadTransform(const Node& node, const std::string& name) {
  node.RequireKeysAmong({"translation_m", "rotation_xyzw"});
  const auto t = node["translation_m"].Numbers<3>();
  const auto q = node["rotation_xyzw"].Numbers<4>();
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  ThrowIf(!(std::abs(rotation.norm() - 1) < 0.01), name, ": rotation_xyzw has norm ",
          rotation.norm(), ", must be 1");
  return Rigid3d(rotation.normalized(), {t[0], t[1], t[2]});
}

RgbdCamera ReadCamera(const Node& root, const std::string& path) {
  root.RequireKeysAmong({"depth_camera", "color_camera", "color_from_depth",
                         "depth_units_per_metre", "disparity", "inverse_depth_sigma",
                         "inverse_depth_field", "frames_per_second", "latency_s", "color_latency_s",
                         "readout_s", "prior", "imu"});
  RgbdCamera camera;
  ThrowIf(!root["depth_camera"].Exists(), path, ": depth_camera is missing");
  camera.depth = ReadPinhole(root["depth_camera"]);
  if (root["disparity"].Exists()) {
    ThrowIf(root["depth_units_per_metre"].Exists(), path,
            ": has depth_units_per_metre and disparity, must have only one of them");
    camera.disparity = ReadDisparity(root["disparity"], path + ": disparity");
  } else {
    camera.depth_units_per_metre = root["depth_units_per_metre"].Number();
  }
  const auto read = [&](const char* key, double* number) {
    if (root[key].Exists()) *number = root[key].Number();
  };
  read("inverse_depth_sigma", &camera.noise.inverse_depth_sigma);
  read("frames_per_second", &camera.frames_per_second);
  read("latency_s", &camera.latency_s);
  read("color_latency_s", &camera.color_latency_s);
  read("readout_s", &camera.readout_s);
  if (root["prior"].Exists()) camera.prior = ReadPrior(root["prior"]);
  camera.color_is_registered = !root["color_camera"].Exists();
  if (!camera.color_is_registered) camera.color = ReadPinhole(root["color_camera"]);
  if (root["color_from_depth"].Exists()) {
    ThrowIf(camera.color_is_registered, path, ": color_from_depth needs color_camera");
    camera.color_from_depth = ReadTransform(root["color_from_depth"], path + ": color_from_depth");
  }
  camera.Validate(path);
  return camera;
}

void WritePinhole(cv::FileStorage& file, const char* key, const PinholeCamera& camera) {
  file << key << "{:"
       << "width" << camera.width << "height" << camera.height;
  file << "fx" << camera.fx << "fy" << camera.fy << "cx" << camera.cx << "cy" << camera.cy;
  file << "distortion"
       << "[:";
  for (const double k : camera.distortion) file << k;
  file << "]"
       << "}";
}

void WriteDisparity(cv::FileStorage& file, const Disparity& disparity) {
  file << "disparity"
       << "{:"
       << "focal_px" << disparity.focal_px << "baseline_m" << disparity.baseline_m
       << "counts_per_px" << disparity.counts_per_px << "count_at_infinity"
       << disparity.count_at_infinity << "}";
}

void WriteTransform(cv::FileStorage& file, const char* key, const Rigid3d& transform) {
  file << key << "{:"
       << "translation_m"
       << "[:";
  for (int i = 0; i < 3; ++i) file << transform.translation[i];
  file << "]"
       << "rotation_xyzw"
       << "[:";
  for (int i = 0; i < 4; ++i) file << transform.rotation.coeffs()[i];
  file << "]"
       << "}";
}

void WriteField(cv::FileStorage& file, const InverseDepthField& field) {
  file << "inverse_depth_field"
       << "[:";
  for (const double c : field.coefficients) file << c;
  file << "]";
}

// Writes the prior unless it is equal to the default.
void WritePrior(cv::FileStorage& file, CalibrationPrior prior) {
  CalibrationPrior usual;
  const Numbers numbers = NumbersOf(&prior), defaults = NumbersOf(&usual);
  const auto is_same = [](const auto& a, const auto& b) { return *a.second == *b.second; };
  if (std::equal(numbers.all.begin(), numbers.all.end(), defaults.all.begin(), is_same)) return;
  file << "prior"
       << "{:";
  for (const auto& [name, number] : numbers.all) file << name << *number;
  file << "}";
}

std::vector<std::pair<std::string, double*>> ImuNumbers(ImuCalibration* calibration) {
  std::vector<std::pair<std::string, double*>> numbers = {
      {"time_offset_s", &calibration->time_offset_s},
      {"time_offset_sigma_s", &calibration->time_offset_sigma_s},
      {"rotation_sigma_rad", &calibration->rotation_sigma_rad},
      {"translation_sigma_m", &calibration->translation_sigma_m}};
  const Numbers noise = NumbersOf(&calibration->noise);
  numbers.insert(numbers.end(), noise.all.begin(), noise.all.end());
  return numbers;
}

ImuCalibration ReadImuNode(const Node& node, ImuCalibration calibration, const std::string& name) {
  std::vector<std::string> keys = {"camera_from_imu"};
  for (const auto& [key, number] : ImuNumbers(&calibration)) keys.push_back(key);
  node.RequireKeysAmong(keys);
  if (node["camera_from_imu"].Exists()) {
    calibration.camera_from_imu =
        ReadTransform(node["camera_from_imu"], name + ": camera_from_imu");
    calibration.rotation_sigma_rad = 0.005;
    calibration.translation_sigma_m = 0.01;
  }
  if (node["time_offset_s"].Exists()) calibration.time_offset_sigma_s = 0.003;
  for (const auto& [key, number] : ImuNumbers(&calibration)) {
    if (node[key].Exists()) *number = node[key].Number();
  }
  ThrowIf(!(std::abs(calibration.time_offset_s) <= 1), name, ": time_offset_s is ",
          calibration.time_offset_s, ", must be from -1 to 1 (s)");
  for (const auto& [key, sigma] :
       {std::pair("time_offset_sigma_s", calibration.time_offset_sigma_s),
        std::pair("rotation_sigma_rad", calibration.rotation_sigma_rad),
        std::pair("translation_sigma_m", calibration.translation_sigma_m)}) {
    ThrowIf(!(sigma >= 0), name, ": ", key, " is ", sigma, ", must be at least 0");
  }
  calibration.noise.Validate(name);
  return calibration;
}

void WriteImu(cv::FileStorage& file, ImuCalibration calibration) {
  file << "imu"
       << "{";
  WriteTransform(file, "camera_from_imu", calibration.camera_from_imu);
  for (const auto& [key, number] : ImuNumbers(&calibration)) file << key << *number;
  file << "}";
}

// Reads a file. Throws InputError if the file has too many lists and maps for the recursive parser.
// A camera file has about 12.
std::string ReadShallowText(const std::string& path) {
  constexpr std::size_t kMost = 1 << 16;  // bytes, enough for 360 levels of indentation
  constexpr int kMaxOpened = 200;
  ThrowIf(!HasFile(path), path, " does not exist");
  std::string text = ReadFile(path, kMost);
  int opened = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    const char c = text[i];
    opened += c == '[' || c == '{' || (c == '-' && text[i + 1] == ' ');
  }
  if (opened <= kMaxOpened) return text;
  throw InputError(path, " has ", opened, " lists and maps, must have at most ", kMaxOpened);
}

}  // namespace

RgbdCamera ReadCameraYaml(const std::string& path) {
  const YamlNode root = ParseYaml(ReadShallowText(path), path);
  return ReadCamera(Node(&root, path), path);
}

InverseDepthField ReadInverseDepthField(const std::string& path) {
  const YamlNode root = ParseYaml(ReadShallowText(path), path);
  InverseDepthField field;
  const Node node = Node(&root, path)["inverse_depth_field"];
  if (node.Exists()) field.coefficients = node.Numbers<InverseDepthField::kSize>();
  return field;
}

ImuCalibration ReadImuCalibration(const std::string& path, ImuCalibration calibration) {
  const YamlNode root = ParseYaml(ReadShallowText(path), path);
  const Node node = Node(&root, path)["imu"];
  return node.Exists() ? ReadImuNode(node, calibration, path + ": imu") : calibration;
}

void WriteCameraYaml(const RgbdCamera& camera, const std::string& path,
                     const InverseDepthField& field, const ImuCalibration* imu) {
  std::string text;
  try {
    cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    WritePinhole(file, "depth_camera", camera.depth);
    if (!camera.color_is_registered) {
      WritePinhole(file, "color_camera", camera.color);
      WriteTransform(file, "color_from_depth", camera.color_from_depth);
    }
    if (camera.disparity.IsGiven()) {
      WriteDisparity(file, camera.disparity);
    } else {
      file << "depth_units_per_metre" << camera.depth_units_per_metre;
    }
    file << "inverse_depth_sigma" << camera.noise.inverse_depth_sigma;
    if (!field.IsZero()) WriteField(file, field);
    file << "frames_per_second" << camera.frames_per_second;
    file << "latency_s" << camera.latency_s;
    if (camera.color_latency_s != 0) file << "color_latency_s" << camera.color_latency_s;
    file << "readout_s" << camera.readout_s;
    WritePrior(file, camera.prior);
    if (imu != nullptr) WriteImu(file, *imu);
    text = file.releaseAndGetString();
  } catch (const cv::Exception& error) {
    throw InputError(path, " cannot be written: ", error.err);
  }
  WriteFileAtomically(path, [&](std::ostream& out) { out << text; });
}

}  // namespace surfit
