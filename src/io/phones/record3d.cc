// Reads the export "EXR + JPG sequence" of Record3D. The answers of its author in the issues of the
// project record3d describe the files:
//   rgb/N.jpg, depth/N.exr   depth in m
//   metadata.json            w, h: size of colour; K: 3 x 3 intrinsics of colour, column by column;
//                            per frame: poses (qx qy qz qw tx ty tz), and in newer versions
//                            perFrameIntrinsicCoeffs (fx fy cx cy) and frameTimestamps (s)
// The number N of an image, from 0, is the index of its entries. Poses have the camera axes of
// OpenGL: x right, y up, z backward.
#include "io/phones/json_fields.h"
#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"

namespace surfit {
namespace {

PinholeCamera Record3dLens(const nlohmann::json& json, const std::string& path) {
  PinholeCamera camera;
  SetJsonSize(json, "w", "h", path, &camera);
  ThrowIf(!json.contains("K"), path, ": K is missing, must be 9 numbers");
  const std::vector<double> k = JsonNumbers(json.at("K"), 9, path + ": K");
  for (const std::size_t zero : {1, 2, 3, 5})
    ThrowIf(k[zero] != 0, path, ": K[", zero, "] is ", k[zero],
            ", must be 0: the columns are fx 0 0, 0 fy 0 and cx cy 1");
  return LensOf({camera.width, camera.height}, {k[0], k[4], k[6], k[7]}, path + ": K");
}

// Array of a field; empty if it is absent or null.
const nlohmann::json& ArrayOf(const nlohmann::json& json, const char* key,
                              const std::string& path) {
  static const nlohmann::json none = nlohmann::json::array();
  if (!json.contains(key) || json.at(key).is_null()) return none;
  ThrowIf(!json.at(key).is_array(), path, ": ", key, " is not an array");
  return json.at(key);
}

ParsedRigid Record3dPose(const nlohmann::json& pose, const std::string& place) {
  const std::vector<double> n = JsonNumbers(pose, 7, place);
  const std::array<double, 7> position_first = {n[4], n[5], n[6], n[0], n[1], n[2], n[3]};
  try {
    return {RigidFromNumbers(position_first.data()), ""};
  } catch (const InputError& error) {
    return {std::nullopt, Concat(place, ": ", error.what())};
  }
}

}  // namespace

PhoneFiles ListRecord3d(const std::string& folder, bool confidence) {
  const std::string exported = folder + "/EXR_RGBD";
  const std::string root = IsFolder(exported) ? exported : folder, path = root + "/metadata.json";
  PhoneFiles files;
  files.camera_from = path;
  WithJsonFile(path, [&](const nlohmann::json& json) {
    const PinholeCamera shared_lens = Record3dLens(json, path);
    const nlohmann::json &lenses = ArrayOf(json, "perFrameIntrinsicCoeffs", path),
                         &stamps = ArrayOf(json, "frameTimestamps", path),
                         &poses = ArrayOf(json, "poses", path);
    files.has_clock = !stamps.empty();
    const double fps = files.has_clock ? 1 : JsonNumber(json, "fps", path);
    ThrowIf(!(fps > 0), path, ": fps is ", fps, ", must be positive");
    std::size_t without_stamp = 0, without_lens = 0, without_color = 0, without_depth = 0;
    for (const FrameFiles& listed : ListNumberedFrames(root + "/depth", root + "/rgb")) {
      const auto number = static_cast<std::size_t>(listed.stamps.depth_s);
      const auto place = [&](const char* key) { return Concat(path, ": ", key, "[", number, "]"); };
      if (!IsFile(listed.depth_path)) {
        ++without_depth;
        continue;
      }
      if (files.has_clock && number >= stamps.size()) {
        ++without_stamp;
        continue;
      }
      double stamp_s = static_cast<double>(number) / fps;
      if (files.has_clock) {
        ThrowIf(!stamps[number].is_number(), place("frameTimestamps"), " is ",
                stamps[number].dump(), ", must be a number");
        stamp_s = stamps[number].get<double>();
      }
      PhoneFrame frame;
      frame.files = listed;
      frame.files.stamps = {stamp_s, stamp_s};
      if (!IsFile(listed.color_path)) {
        frame.files.color_path.clear();
        ++without_color;
      }
      frame.color_camera = shared_lens;
      if (number < lenses.size()) {
        const std::vector<double> lens =
            JsonNumbers(lenses[number], 4, place("perFrameIntrinsicCoeffs"));
        frame.color_camera =
            LensOf({shared_lens.width, shared_lens.height}, {lens[0], lens[1], lens[2], lens[3]},
                   place("perFrameIntrinsicCoeffs"));
      } else {
        without_lens += !lenses.empty();
      }
      if (number < poses.size())
        files.poses.AddOpenGl(stamp_s, Record3dPose(poses[number], place("poses")));
      files.frames.push_back(std::move(frame));
    }
    files.unpaired_images = static_cast<int>(without_depth + without_stamp + without_color);
    WarnOfCount(without_depth, root + "/rgb", "images have no depth and are left out",
                &files.warnings);
    WarnOfCount(without_color, root + "/depth", "images have no colour in rgb/", &files.warnings);
    WarnOfCount(without_stamp, path, "frames have no entry in frameTimestamps and are left out",
                &files.warnings);
    WarnOfCount(without_lens, path,
                "frames have no entry in perFrameIntrinsicCoeffs: K is used for them",
                &files.warnings);
    return 0;
  });
  ThrowIf(files.frames.empty(), root, ": depth/ has no image N.exr");
  if (confidence) AddPhoneConfidence(ConfidenceFolder(root), &files);
  return files;
}

}  // namespace surfit
