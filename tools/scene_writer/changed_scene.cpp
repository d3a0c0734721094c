// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/scene_writer/changed_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>

#include "framework/scene/change_table.h"
#include "framework/scene/names.h"
#include "framework/scene/overrides.h"
#include "framework/scene/text.h"
#include "framework/simulation/simulation.h"
#include "tools/scene_writer/scene_text.h"

namespace stroma {
namespace {

namespace fs = std::filesystem;

/// An element of the files, as the description has it.
struct Element {
  std::string path;
  const std::vector<AttributeDescription>* attributes;
  const SourceLocation* where;
  bool is_node = false;  ///< a component may have the path of a node
};

void collectElements(const NodeDescription& node, const std::string& path, std::vector<Element>& elements) {
  const std::vector<std::string> components = componentNames(node), children = childNames(node);
  elements.push_back({path, &node.attributes, &node.where, true});
  for (std::size_t i = 0; i < components.size(); ++i)
    elements.push_back({joinPath(path, components[i]), &node.components[i].attributes, &node.components[i].where});
  for (std::size_t i = 0; i < children.size(); ++i)
    collectElements(node.children[i], joinPath(path, children[i]), elements);
}

/// One place of a text: a tag that gets an attribute, or an attribute.
struct Place {
  std::string file;  ///< canonical
  int line = 0, column = 0;
  std::string added;  ///< the name of the attribute that the tag gets, or empty
  bool operator<(const Place& other) const {
    return std::tie(file, line, column, added) < std::tie(other.file, other.line, other.column, other.added);
  }
  bool operator==(const Place& other) const { return !(*this < other) && !(other < *this); }
};

/// An edit and where it belongs.
struct WantedEdit {
  std::string name;     ///< "/organ/fem.youngModulus"
  std::string element;  ///< its path
  bool is_node = false;
  std::string attribute;  ///< present name
  std::string value;
  SourceLocation where;
  Place place;
  bool is_there = false;  ///< the text says so already
  bool isOf(const Element& other) const { return other.path == element && other.is_node == is_node; }
};

class Writer {
 public:
  explicit Writer(const Simulation& simulation) : simulation_(simulation), scene_(simulation.scene().description) {
    collectElements(scene_.root, "/", elements_);
  }

  ChangedScene run() {
    for (const SceneFileText& text : scene_.texts) result_.texts.emplace(text.file, text.text);
    for (const Override& edit : simulation_.edits()) locate(edit);
    for (const WantedEdit& wanted : wanted_)
      if (!wanted.is_there && isAlone(wanted)) changes_[nameOf(wanted.place.file)].push_back(changeOf(wanted));
    for (const auto& [file, changes] : changes_) write(file, changes);
    tellOverrides();
    tellDisk();
    return std::move(result_);
  }

 private:
  void refuse(const std::string& name, const std::string& value, const std::string& why) {
    result_.not_written.push_back(fmt::format("{} = {} is not written: {}", name, inQuotes(value), why));
  }

  static std::string canonical(const std::string& file) {
    std::error_code none;
    const std::string path = fs::weakly_canonical(file, none).string();
    return path.empty() ? file : path;
  }
  /// A file that was included under several names is known by the first.
  const SceneFileText* textOf(const std::string& canonical_file) const {
    for (const SceneFileText& text : scene_.texts)
      if (canonical(text.file) == canonical_file) return &text;
    return nullptr;
  }
  std::string nameOf(const std::string& canonical_file) const { return textOf(canonical_file)->file; }

  // ---- from an edit to a place ----

  void locate(const Override& edit) {
    const LiveEdit live(simulation_.root(), edit.path, edit.attribute);
    const Component* component = live.component();
    WantedEdit wanted{
        live.name(), component ? component->path() : live.node()->path(), !component, edit.attribute, edit.value, {},
        {}};
    if (component) wanted.attribute = component->data().find(edit.attribute)->name();
    // the same attribute by another path or name: the last counts
    std::erase_if(wanted_, [&](const WantedEdit& other) { return other.name == wanted.name; });
    const auto element =
        std::find_if(elements_.begin(), elements_.end(), [&](const Element& each) { return wanted.isOf(each); });
    if (scene_.texts.empty()) return refuse(wanted.name, wanted.value, "the scene was not read from a text");
    if (element == elements_.end())
      return refuse(wanted.name, wanted.value,
                    fmt::format("no element of the scene is {}, which was made with its defaults beside the component "
                                "of {} that cannot do without it; an element <{} name={}> gives it a place",
                                wanted.element, component ? component->where().text() : "the scene",
                                component ? component->type() : "Node", inQuotes(component ? component->name() : "")));
    findPlace(*element, component, wanted);
    const SceneFileText* text = textOf(wanted.place.file);
    if (!text) return refuse(wanted.name, wanted.value, "the text of " + wanted.where.file + " was not kept");
    if (text->is_prefab)
      return refuse(wanted.name, wanted.value,
                    fmt::format("{} was made by the prefab {}, and other elements may be made by it too; the element "
                                "that names the prefab can give the attribute",
                                wanted.element, wanted.where.text()));
    wanted_.push_back(std::move(wanted));
  }

  /// Where the value stands in a file, else the tag that gets the attribute.
  void findPlace(const Element& element, const Component* component, WantedEdit& wanted) const {
    wanted.where = *element.where;
    wanted.place = {canonical(element.where->file), element.where->line, element.where->column, wanted.attribute};
    for (const AttributeDescription& attribute : *element.attributes) {
      if (!isCalled(attribute.name, wanted.attribute, component)) continue;
      const bool is_overridden = isOverride(attribute.where);
      const SourceLocation& where = is_overridden ? attribute.overridden : attribute.where;
      if (where.line == 0) continue;
      wanted.where = where;
      wanted.place = {canonical(where.file), where.line, where.column, {}};
      wanted.is_there = !is_overridden && attribute.value == wanted.value;
    }
  }

  /// True when `written` is a name of the attribute: its own, another accepted one or an old one.
  static bool isCalled(const std::string& written, const std::string& attribute, const Component* component) {
    if (!component || written == attribute) return written == attribute;
    const Data* data = component->data().find(written);
    for (const AttributeChange& change : attributeChanges())
      if (!data && change.type == component->type() && change.old_attribute == written)
        data = component->data().find(change.new_attribute);
    return data && data->name() == attribute;
  }

  // ---- a place that several elements share ----

  /// False when another element would change too that is not to change so.
  bool isAlone(const WantedEdit& wanted) {
    for (const Element& element : elements_) {
      if (wanted.isOf(element) || !isMadeAt(element, wanted.place)) continue;
      const bool agrees = std::any_of(wanted_.begin(), wanted_.end(), [&](const WantedEdit& other) {
        return other.isOf(element) && other.place == wanted.place && other.value == wanted.value;
      });
      if (agrees) continue;
      refuse(wanted.name, wanted.value,
             fmt::format("{} makes {} too, which would change with it; set it there as well, or write the two apart",
                         wanted.where.text(), element.path));
      return false;
    }
    return true;
  }

  static bool isAt(const SourceLocation& where, const Place& place) {
    return where.line == place.line && where.column == place.column && canonical(where.file) == place.file;
  }
  static bool isMadeAt(const Element& element, const Place& place) {
    if (!place.added.empty()) return isAt(*element.where, place);
    return std::any_of(element.attributes->begin(), element.attributes->end(), [&](const auto& attribute) {
      return isAt(isOverride(attribute.where) ? attribute.overridden : attribute.where, place);
    });
  }

  // ---- texts ----

  static TextChange changeOf(const WantedEdit& wanted) {
    return {{wanted.place.line, wanted.place.column}, wanted.attribute, wanted.value};
  }

  void write(const std::string& file, const std::vector<TextChange>& changes) {
    std::string& text = result_.texts.at(file);
    try {
      std::string changed = changedText(text, changes);
      if (changed == text) return;
      text = std::move(changed);
      result_.changed.push_back(file);
    } catch (const std::invalid_argument& error) {
      result_.not_written.push_back(fmt::format("no edit is written to {}: {}", file, error.what()));
    }
  }

  /// What `--set` gave is of this run and not of its files.
  void tellOverrides() {
    for (const Element& element : elements_)
      for (const AttributeDescription& attribute : *element.attributes) {
        const auto is_edited = [&](const WantedEdit& wanted) {
          const Component* component = wanted.is_node ? nullptr : findComponent(simulation_.root(), wanted.element);
          return wanted.isOf(element) && isCalled(attribute.name, wanted.attribute, component);
        };
        if (isOverride(attribute.where) && std::none_of(wanted_.begin(), wanted_.end(), is_edited))
          result_.notes.push_back(
              fmt::format("{}={} of the start of the run is not in the text", attribute.where.file, attribute.value));
      }
  }

  void tellDisk() {
    for (const SceneFileText& text : scene_.texts) {
      if (!text.is_on_disk) continue;
      std::ostringstream now;
      std::ifstream file(text.file, std::ios::binary);
      if (file && file.peek() != std::ifstream::traits_type::eof()) now << file.rdbuf();
      if (file && now.str() == text.text) continue;
      const std::string note = fmt::format("{} {} since it was loaded: the text is the one that was loaded", text.file,
                                           file ? "has changed" : "cannot be read any more");
      if (std::find(result_.notes.begin(), result_.notes.end(), note) == result_.notes.end())
        result_.notes.push_back(note);
    }
  }

  const Simulation& simulation_;
  const SceneDescription& scene_;
  std::vector<Element> elements_;
  std::vector<WantedEdit> wanted_;
  std::map<std::string, std::vector<TextChange>> changes_;  ///< by file
  ChangedScene result_;
};

}  // namespace

ChangedScene changedScene(const Simulation& simulation) { return Writer(simulation).run(); }

}  // namespace stroma
