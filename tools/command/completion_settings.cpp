// SPDX-License-Identifier: LGPL-2.1-or-later
// What --set completes: paths of a scene as in a folder, attributes after a dot, choices after "=".
#include <algorithm>
#include <filesystem>

#include "framework/scene/change_table.h"
#include "framework/scene/names.h"
#include "framework/scene/prefab.h"
#include "tools/command/completion.h"

namespace stroma::command {
namespace {

using CandidateKind = Candidate::Kind;

/// A larger scene takes longer to read than a key press may.
constexpr std::size_t largest_scene = 4u << 20;

/// A node and its children by path; the component, if the path leads to one.
struct Place {
  const NodeDescription* node = nullptr;
  const ComponentDescription* component = nullptr;
};

/// What stands in a node, with the names that paths have.
template <class F>
void forPlaces(const NodeDescription& node, F&& f) {
  const auto components = componentNames(node), children = childNames(node);
  for (std::size_t i = 0; i < children.size(); ++i) f(children[i], Place{&node.children[i], nullptr});
  for (std::size_t i = 0; i < components.size(); ++i) f(components[i], Place{nullptr, &node.components[i]});
}

Place follow(const NodeDescription& root, std::string_view path) {
  Place place{&root, nullptr};
  while (!path.empty()) {
    const auto slash = std::min(path.find('/'), path.size());
    const std::string_view step = path.substr(0, slash);
    path.remove_prefix(std::min(slash + 1, path.size()));
    if (step.empty()) continue;
    if (!place.node) return {};
    Place next;
    forPlaces(*place.node, [&](const std::string& name, const Place& there) {
      if (name == step && !next.node && !next.component) next = there;
    });
    place = next;
  }
  return place;
}

const AttributeDescription* written(const Place& place, const std::string& attribute) {
  return place.component ? place.component->find(attribute) : place.node ? place.node->find(attribute) : nullptr;
}

/// A value that is short enough to be read beside its name, and is one word.
bool isShort(const std::string& value) {
  return !value.empty() && value.size() <= 40 && value.find_first_of(" \t\n,\"'$") == std::string::npos;
}

class Settings {
 public:
  Settings(const NodeDescription& root, Factory& factory, Modules& modules)
      : root_(root), factory_(factory), modules_(modules) {}

  std::vector<Candidate> paths(const std::string& typed) {
    const std::string folder = typed.substr(0, typed.rfind('/') + 1);
    const Place place = follow(root_, folder);
    if (!place.node) return {};
    if (folder.empty()) attributesOfNode("", {&root_, nullptr});
    const std::string front = typed.empty() ? "/" : folder;
    forPlaces(*place.node, [&](const std::string& name, const Place& there) {
      if (there.node)
        out_.push_back({front + name + "/", "node", CandidateKind::start});
      else
        out_.push_back({front + name + ".", there.component->type, CandidateKind::start});
    });
    return std::move(out_);
  }

  std::vector<Candidate> attributes(const std::string& path) {
    const Place place = follow(root_, path);
    if (place.node) attributesOfNode(path + ".", place);
    if (!place.component) return std::move(out_);
    made_ = make(place);
    if (!made_) return {};
    for (const Data& data : made_->data().all()) {
      if (data.isOutput()) continue;
      const AttributeDescription* now = written(place, data.name());
      const std::string value = now && isShort(now->value) ? "[" + now->value + "] " : "";
      out_.push_back({path + "." + data.name() + "=", value + data.helpText(), CandidateKind::start});
    }
    return std::move(out_);
  }

  /// The choices; of other types the value that the scene has and the default.
  std::vector<Candidate> values(const std::string& path, const std::string& attribute) {
    const Place place = follow(root_, path);
    made_ = place.component ? make(place) : nullptr;
    const Data* data = made_ ? made_->data().find(attribute) : nullptr;
    std::vector<std::string> words;
    if (data)
      if (const auto* choice = std::get_if<ChoiceRef>(&data->pointer())) words = choice->words;
    if (data && std::holds_alternative<bool*>(data->pointer())) words = {"true", "false"};
    if (data && data->link()) words = data->link()->words;
    const AttributeDescription* now = written(place, attribute);
    if (words.empty() && now && isShort(now->value)) words = {now->value};
    if (words.empty() && data && isShort(data->defaultText())) words = {data->defaultText()};
    for (const std::string& word : words) out_.push_back({word, now && now->value == word ? "as written" : ""});
    return std::move(out_);
  }

 private:
  void attributesOfNode(const std::string& front, const Place& place) {
    out_.push_back({front + "gravity=", "[m/s^2] three numbers", CandidateKind::start});
    if (place.node != &root_) return;
    out_.push_back({front + "dt=", "[s] the time step", CandidateKind::start});
    out_.push_back({front + "time=", "[s] at the start", CandidateKind::start});
  }

  std::unique_ptr<Component> make(const Place& place) {
    const std::string& type = place.component->type;
    if (!modules_.provide(type)) return nullptr;
    auto component = factory_.make(type);
    return component ? std::move(component) : factory_.make(std::string(presentType(type)));
  }

  const NodeDescription& root_;
  Factory& factory_;
  Modules& modules_;
  std::unique_ptr<Component> made_;
  std::vector<Candidate> out_;
};

}  // namespace

std::vector<Candidate> settings(const std::string& file, const std::string& typed) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  Factory factory;
  Modules modules(factory);
  Diagnostics diagnostics;
  ReadLimits limits;
  limits.file_bytes = largest_scene;
  const SceneDescription scene =
      readSceneWithPrefabs(file, {}, limits, knownTypes(factory, modules), diagnostics, nullptr);
  if (scene.root.where.file.empty() || diagnostics.hasErrors()) return {};
  Settings answers(scene.root, factory, modules);
  const auto equals = typed.find('=');
  const auto dot = typed.substr(0, equals).rfind('.');
  if (equals == std::string::npos)
    return dot == std::string::npos ? answers.paths(typed) : answers.attributes(typed.substr(0, dot));
  const std::string path = dot == std::string::npos ? "" : typed.substr(0, dot);
  const std::string attribute =
      typed.substr(dot == std::string::npos ? 0 : dot + 1, equals - (dot == std::string::npos ? 0 : dot + 1));
  auto list = answers.values(path, attribute);
  for (Candidate& candidate : list) candidate.text = typed.substr(0, equals + 1) + candidate.text;
  return list;
}

}  // namespace stroma::command
