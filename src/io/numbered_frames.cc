#include "io/numbered_frames.h"

#include <map>

#include "io/folder.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// The images of a folder by number.
std::map<long, std::string> NumberedImages(const std::string& folder) {
  std::map<long, std::string> images;
  for (const std::string& name : NamesIn(folder)) {
    const auto number = NumberInName(name);
    for (const char* ending : {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif", ".tiff"}) {
      if (!number || !EndsWith(name, ending)) continue;
      const auto [it, is_new] = images.emplace(*number, name);
      if (!is_new)
        throw InputError(Concat(folder, ": ", it->second, " and ", name, " are both number ",
                                *number, ", must be one image a number"));
    }
  }
  return images;
}

// The image of this number, or the name it should have: another folder's with our ending.
std::string NameOf(long number, const std::map<long, std::string>& images,
                   const std::map<long, std::string>& others) {
  const auto it = images.find(number);
  if (it != images.end()) return it->second;
  const std::string& other = others.at(number);
  const std::string& some = images.empty() ? other : images.begin()->second;
  return other.substr(0, other.rfind('.')) + some.substr(some.rfind('.'));
}

}  // namespace

std::string FindColorFolder(const std::string& folder) {
  for (const char* name : {"/color", "/rgb", "/image"}) {
    if (IsFolder(folder + name)) return folder + name;
  }
  return "";
}

std::vector<FrameFiles> ListNumberedFrames(const std::string& depth_folder,
                                           const std::string& color_folder) {
  const auto depth = NumberedImages(depth_folder);
  const auto color = color_folder.empty() ? depth : NumberedImages(color_folder);
  std::map<long, FrameFiles> frames;
  for (const auto& [number, name] : color) frames[number];
  for (const auto& [number, name] : depth) frames[number];
  std::vector<FrameFiles> sorted;
  for (auto& [number, frame] : frames) {
    frame.stamp_s = static_cast<double>(number);
    frame.depth_path = depth_folder + "/" + NameOf(number, depth, color);
    if (!color_folder.empty()) frame.color_path = color_folder + "/" + NameOf(number, color, depth);
    sorted.push_back(frame);
  }
  return sorted;
}

}  // namespace surfit
