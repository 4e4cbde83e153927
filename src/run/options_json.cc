#include "run/options_json.h"

#include "surfit/core/error.h"

namespace surfit {
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
