#include "io/bags/bag_topics.h"

#include <algorithm>

#include "io/bags/message_images.h"
#include "io/sequences/folder.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

struct Candidate {
  ImageTopic image;
  ImageKind kind = ImageKind::kUnreadable;
  bool is_compressed = false;
  std::string encoding;
  std::string base;  // topic name without the suffix of image_transport
};

bool IsReadable(const Topic& topic) {
  return topic.serialization != Serialization::kOther && !topic.messages.empty();
}

bool IsImage(const Topic& topic) {
  return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage";
}

std::string BaseOf(const std::string& name) {
  for (const char* ending : {"/compressed", "/compressedDepth"}) {
    if (EndsWith(name, ending)) return name.substr(0, name.rfind('/'));
  }
  return name;
}

std::vector<Candidate> Candidates(const MessageLog& log) {
  std::vector<Candidate> candidates;
  for (const Topic& topic : log.topics()) {
    if (!IsImage(topic) || !IsReadable(topic)) continue;
    const std::string name = Concat(log.path(), ": the first message of ", topic.name);
    const ImageMessage first = ReadImageMessage(log.Read(topic.messages[0]), topic, name);
    candidates.push_back({{&topic, first.header.frame, first.width, first.height},
                          KindOf(first, topic.name),
                          first.is_compressed,
                          first.encoding,
                          BaseOf(topic.name)});
  }
  return candidates;
}

// Topics and encodings for error messages, for example "/camera/depth/image (16UC1), ...".
std::string List(const std::vector<Candidate>& candidates) {
  std::string list;
  for (const Candidate& c : candidates)
    list += Concat(list.empty() ? "" : ", ", c.image.topic->name, " (", c.encoding, ")");
  return list;
}

// All non-empty topics and their types, for error messages.
std::string ListTypes(const MessageLog& log) {
  std::string list;
  for (const Topic& topic : log.topics()) {
    if (topic.messages.empty()) continue;
    list += Concat(list.empty() ? "" : ", ", topic.name, " (", topic.type, ")");
  }
  return list.empty() ? "no messages" : list;
}

// Compressed topics are omitted if they also exist uncompressed.
std::vector<Candidate> OfKind(const std::vector<Candidate>& candidates, ImageKind kind) {
  std::vector<Candidate> chosen;
  for (const Candidate& c : candidates) {
    if (c.kind != kind) continue;
    const bool is_twice =
        std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& d) {
          return c.is_compressed && !d.is_compressed && d.kind == kind && d.base == c.base;
        });
    if (!is_twice) chosen.push_back(c);
  }
  return chosen;
}

ImageTopic Named(const std::string& name, const char* option, const MessageLog& log,
                 const std::vector<Candidate>& candidates) {
  for (const Candidate& c : candidates) {
    if (c.image.topic->name == name) return c.image;
  }
  throw InputError(option, " is '", name, "', must be an image topic of ", log.path(), ": ",
                   candidates.empty() ? "it has none" : List(candidates));
}

ImageTopic OnlyOne(const std::vector<Candidate>& found, const char* what, const char* option,
                   const MessageLog& log) {
  if (found.size() == 1) return found[0].image;
  throw InputError(log.path(), " has ", found.size(), " topics with ", what, ": ", List(found),
                   "; select one with ", option, " (--topics)");
}

ImageTopic FindDepth(const MessageLog& log, const std::vector<Candidate>& candidates) {
  if (candidates.empty()) {
    throw InputError(log.path(), " has no readable image topic; it has ", ListTypes(log));
  }
  const auto found = OfKind(candidates, ImageKind::kDepth);
  if (found.empty()) {
    throw InputError(log.path(), " has no topic with depth images (16UC1, 32FC1) among ",
                     List(candidates),
                     "; if one of them has depth, select it with depth_topic (--topics)");
  }
  return OnlyOne(found, "depth images", "depth_topic", log);
}

ImageTopic FindColor(const MessageLog& log, const std::vector<Candidate>& candidates) {
  auto found = OfKind(candidates, ImageKind::kColor);
  if (found.empty()) found = OfKind(candidates, ImageKind::kGrey);
  if (found.empty()) return {};
  return OnlyOne(found, "colour images", "color_topic", log);
}

std::string ParentOf(const std::string& name) { return name.substr(0, name.rfind('/')); }

}  // namespace

BagTopics FindTopics(const MessageLog& log, const std::string& depth, const std::string& color) {
  const std::vector<Candidate> candidates = Candidates(log);
  BagTopics topics;
  topics.depth =
      depth.empty() ? FindDepth(log, candidates) : Named(depth, "depth_topic", log, candidates);
  if (color == "none") return topics;
  topics.color =
      color.empty() ? FindColor(log, candidates) : Named(color, "color_topic", log, candidates);
  return topics;
}

const Topic* FindDepthUnit(const MessageLog& log, const ImageTopic& depth) {
  const std::string ending = "/option/Depth_Units/value";
  for (const Topic& topic : log.topics()) {
    if (topic.type != "std_msgs/Float32" || !IsReadable(topic)) continue;
    if (!EndsWith(topic.name, ending)) continue;
    const std::string sensor = topic.name.substr(0, topic.name.size() - ending.size()) + "/";
    if (depth.topic->name.compare(0, sensor.size(), sensor) == 0) return &topic;
  }
  return nullptr;
}

const Topic* FindCameraInfo(const MessageLog& log, const ImageTopic& image) {
  const std::string base = BaseOf(image.topic->name), parent = ParentOf(base);
  const std::vector<std::string> names = {parent + "/camera_info", base + "/camera_info",
                                          ParentOf(parent) + "/info/camera_info"};
  std::vector<const Topic*> infos, of_frame;
  for (const Topic& topic : log.topics()) {
    if (topic.type == "sensor_msgs/CameraInfo" && IsReadable(topic)) infos.push_back(&topic);
  }
  for (const std::string& name : names) {
    for (const Topic* topic : infos) {
      if (topic->name == name) return topic;
    }
  }
  for (const Topic* topic : infos) {
    const std::string name = Concat(log.path(), ": the first message of ", topic->name);
    const CameraInfo info = ReadCameraInfo(log.Read(topic->messages[0]), *topic, name);
    if (info.header.frame == image.frame) of_frame.push_back(topic);
  }
  return of_frame.size() == 1 ? of_frame[0] : nullptr;
}

}  // namespace surfit
