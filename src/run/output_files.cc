#include "run/output_files.h"

#include <filesystem>

#include "core/read_file.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {

void PrepareOutputFolder(const std::string& folder, const std::vector<std::string>& former_files) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError(Concat(folder, ": cannot make the output folder: ", error.message()));
  }
  for (const std::string& name : former_files) {
    fs::remove(fs::path(folder) / name, error);
    if (error) {
      throw InputError(Concat(folder, "/", name, ": cannot be replaced: ", error.message()));
    }
  }
}

Json ReadJson(const std::string& path) {
  try {
    return Json::parse(ReadFile(path));
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": not valid JSON: ", error.what()));
  }
}

void WriteJson(const Json& json, const std::string& path, int indent) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << json.dump(indent, ' ', false, Json::error_handler_t::replace) << '\n';
  });
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
    const Json& json = path_.back()->at(option.name);
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
    path_.push_back(&path_.back()->at(part.name));
    return true;
  }
  void Leave() override { path_.pop_back(); }

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

}  // namespace surfit
