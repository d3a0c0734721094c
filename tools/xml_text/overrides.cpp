// SPDX-License-Identifier: LGPL-2.1-or-later
// `--set PATH.ATTRIBUTE=VALUE` on the description: the attribute is written as if the file said so, and is then checked
// like any other. `--set "PATH=TYPE NAME=VALUE ..."` puts another component in the place of one, which keeps its name.
#include "framework/scene/overrides.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {

static bool beginsAType(std::string_view value) {
  value = trimmed(value);
  return !value.empty() && std::isupper(static_cast<unsigned char>(value[0]));
}

Override Override::parse(const std::string& text) {
  const std::string expected = "expected PATH.ATTRIBUTE=VALUE, for example /liver/fem.method=polar, or PATH=TYPE";
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw std::invalid_argument(inQuotes(text) + " sets nothing: " + expected);
  const std::string left(trimmed(text.substr(0, equals)));
  const auto dot = left.rfind('.');
  const bool is_word = dot == std::string::npos, is_long = is_word && left.find('/') != std::string::npos;
  const std::string_view value = trimmed(std::string_view(text).substr(equals + 1));
  const bool is_type = is_long && beginsAType(value);
  Override result{{}, {}, text.substr(equals + 1)};
  result.path = is_type ? left : is_word ? "/" : left.substr(0, dot);
  if (!is_type && !is_long) result.attribute = left.substr(is_word ? 0 : dot + 1);  // without a path that of the root: dt=0.01
  if (result.path.empty() || result.path[0] != '/') result.path = "/" + result.path;
  if (!is_type && result.attribute.empty())
    throw std::invalid_argument(inQuotes(text) + " names no attribute: " + expected);
  return result;
}

namespace {

constexpr std::string_view written_as = "--set ";

/// Every path of the scene, what it leads to and its attributes.
struct Places {
  std::vector<std::string> paths;
  std::vector<ComponentDescription*> components;  ///< null: a node
  std::vector<std::vector<AttributeDescription>*> attributes;

  void collect(NodeDescription& node, const std::string& path) {
    const std::vector<std::string> names = componentNames(node), children = childNames(node);
    for (std::size_t i = 0; i < names.size(); ++i)
      add(joinPath(path, names[i]), &node.components[i], node.components[i].attributes);
    add(path, nullptr, node.attributes);
    for (std::size_t i = 0; i < children.size(); ++i) collect(node.children[i], joinPath(path, children[i]));
  }
  void add(std::string path, ComponentDescription* component, std::vector<AttributeDescription>& list) {
    paths.push_back(std::move(path)), components.push_back(component), attributes.push_back(&list);
  }
  std::size_t find(const std::string& path) const { return std::size_t(std::ranges::find(paths, path) - paths.begin()); }
};

/// "TYPE NAME=VALUE ...", where a word without = goes on with the value before it. Links and paths find it by its name.
void putInPlace(ComponentDescription& component, const Override& by, const SourceLocation& where, Diagnostics& diagnostics) {
  Words words(by.value);
  component.type = words.next(), component.attributes.clear(), component.where = where;
  for (std::string word(words.next()); !word.empty(); word = words.next()) {
    const auto equals = std::min(word.find('='), word.size());
    const std::string name = word.substr(0, equals);
    if (equals < word.size() && (name == "name" || component.find(name))) {
      diagnostics.error(where, by.path, name == "name" ? "the component keeps its name" : inQuotes(name) + " is given twice");
      return;
    }
    if (equals == word.size() && !component.attributes.empty())
      component.attributes.back().value += " " + word;
    else
      component.attributes.push_back({name, word.substr(std::min(equals + 1, word.size())), where});
  }
  component.attributes.push_back({"name", by.path.substr(by.path.rfind('/') + 1), where});
}

}  // namespace

bool isOverride(const SourceLocation& where) { return where.line == 0 && where.file.starts_with(written_as); }

void applyOverrides(const std::vector<Override>& overrides, NodeDescription& root, Diagnostics& diagnostics) {
  if (overrides.empty()) return;
  Places places;
  places.collect(root, "/");
  const std::string root_path = "/" + (root.name().empty() ? "root" : root.name()) + "/";
  std::vector<Override> sorted = overrides;  // what is in the place of a component has the attributes that others write
  std::stable_partition(sorted.begin(), sorted.end(), [](const Override& change) { return change.attribute.empty(); });
  for (const Override& change : sorted) {
    const bool is_type = change.attribute.empty();
    const SourceLocation where{std::string(written_as) + change.path + (is_type ? "" : "." + change.attribute), 0, 0};
    std::size_t place = places.find(change.path);
    if (place == places.paths.size() && (change.path + "/").starts_with(root_path))  // the root's own name comes first
      place = places.find(change.path.size() < root_path.size() ? "/" : change.path.substr(root_path.size() - 1));
    const bool is_there = place < places.paths.size();
    if (!is_there || (is_type && !places.components[place])) {
      diagnostics.error(where, change.path,
                        is_there ? "this is a node, which no component stands for" : "the scene has no node or component of this path",
                        {}, is_there ? "" : nearest(change.path, places.paths));
    } else if (is_type) {
      putInPlace(*places.components[place], change, where, diagnostics);
    } else if (const std::size_t meant = places.find("/" + change.attribute);
               change.path == "/" && meant < places.paths.size() && places.components[meant] && beginsAType(change.value)) {
      diagnostics.error(where, "/" + change.attribute, "this is a component, and an attribute of the outermost node without a slash", {},
                        "/" + change.attribute + "=" + change.value);
    } else {
      AttributeDescription given{change.attribute, change.value, where};
      std::erase_if(*places.attributes[place], [&](const AttributeDescription& other) {
        if (other.name == change.attribute) given.overridden = isOverride(other.where) ? other.overridden : other.where;
        return other.name == change.attribute;
      });
      places.attributes[place]->push_back(std::move(given));
    }
  }
}

}  // namespace stroma
