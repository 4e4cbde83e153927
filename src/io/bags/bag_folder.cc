#include <utility>

#include "io/bags/message_log.h"
#include "io/sequences/folder.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Bag that the recorder split into several files. MessageLocation::part is an index of `origins_`.
class BagFolder : public MessageLog {
 public:
  BagFolder(std::string folder, const std::string& ending) : folder_(std::move(folder)) {
    for (const std::string& name : NamesIn(folder_)) {
      if (!EndsWith(name, ending)) continue;
      const std::string path = Concat(folder_, "/", name);
      files_.push_back(ending == ".mcap" ? OpenMcap(path) : OpenDb3(path));
      Take(*files_.back());
    }
    ThrowIf(files_.empty(), folder_, " contains no ", ending, " file");
  }

  const std::string& path() const override { return folder_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  std::string Read(const MessageLocation& place) const override {
    const Origin& origin = origins_[place.part];
    MessageLocation inner = place;
    inner.part = origin.part;
    return files_[origin.file]->Read(inner);
  }

 private:
  // File index, and MessageLocation::part inside this file.
  struct Origin {
    std::size_t file = 0;
    int part = -1;
  };

  void Take(const MessageLog& file) {
    const std::size_t number = files_.size() - 1;
    warnings_.insert(warnings_.end(), file.warnings().begin(), file.warnings().end());
    for (const Topic& from : file.topics()) {
      Topic& topic = SameTopic(from);
      for (MessageLocation place : from.messages) {
        if (origins_.empty() || origins_.back().file != number ||
            origins_.back().part != place.part) {
          origins_.push_back({number, place.part});
        }
        place.part = static_cast<int>(origins_.size()) - 1;
        topic.messages.push_back(place);
      }
    }
  }

  Topic& SameTopic(const Topic& other) {
    for (Topic& topic : topics_) {
      if (topic.name == other.name && topic.type == other.type &&
          topic.serialization == other.serialization) {
        return topic;
      }
    }
    topics_.push_back({other.name, other.type, other.serialization, {}});
    return topics_.back();
  }

  std::string folder_;
  std::vector<std::unique_ptr<MessageLog>> files_;
  std::vector<Origin> origins_;
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
};

}  // namespace

std::unique_ptr<MessageLog> OpenBagFolder(const std::string& folder, const std::string& ending) {
  return std::make_unique<BagFolder>(folder, ending);
}

std::string PlainType(std::string type) {
  const std::size_t middle = type.find("/msg/");
  if (middle != type.npos) type.erase(middle, 4);
  return type;
}

}  // namespace surfit
