#include "report/run_json.h"

#include "core/read_file.h"
#include "report/base64.h"
#include "report/packed_map.h"
#include "surfit/core/error.h"
#include "surfit/io/surfel_ply.h"

namespace surfit {
namespace {

using Json = nlohmann::ordered_json;

Json ReadJson(const std::string& path) {
  try {
    return Json::parse(ReadFile(path));
  } catch (const Json::exception& error) {
    throw InputError(Concat(path, ": is no JSON: ", error.what()));
  }
}

// Each view's `files` become `pictures`: the same names, with what the files hold.
void EmbedPictures(const std::string& folder, Json* views) {
  for (Json& view : *views) {
    const Json files = view.at("files");  // a copy: setting a key moves the view's values
    for (const auto& [name, file] : files.items()) {
      const std::string bytes = ReadFile(folder + "/" + file.get<std::string>());
      view["pictures"][name] = "data:image/jpeg;base64," + EncodeBase64(bytes);
    }
    view.erase("files");
  }
}

}  // namespace

Json ReadRun(const std::string& folder, std::size_t max_points) {
  Json run;
  run["label"] = folder;
  run["summary"] = ReadJson(folder + "/summary.json");
  run["frames"] = ReadFile(folder + "/frames.csv");
  const std::string poses = folder + "/poses.json";
  run["poses"] = ReadJson(poses);
  try {
    EmbedPictures(folder, &run["poses"].at("views"));
  } catch (const Json::exception& error) {
    throw InputError(Concat(poses, ": lacks something: ", error.what()));
  }
  run["map"] = PackMap(ReadSurfelPly(folder + "/map.ply"), max_points);
  return run;
}

}  // namespace surfit
