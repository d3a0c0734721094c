// SPDX-License-Identifier: LGPL-2.1-or-later
// `--set PATH.ATTRIBUTE=VALUE` on the description: the attribute is written as if the file said so, and is then checked
// like any other.
#include "framework/scene/overrides.h"

#include <stdexcept>

#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {

Override Override::parse(const std::string& text) {
  const std::string expected = "expected PATH.ATTRIBUTE=VALUE, for example /liver/fem.method=polar";
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw std::invalid_argument(inQuotes(text) + " sets nothing: " + expected);
  const std::string left(trimmed(text.substr(0, equals)));
  const auto dot = left.rfind('.');
  Override result;
  result.value = text.substr(equals + 1);
  if (dot == std::string::npos) {
    if (left.find('/') != std::string::npos)
      throw std::invalid_argument(inQuotes(text) + " names no attribute: " + expected);
    result.path = "/";
    result.attribute = left;  // an attribute of the root: dt=0.01
  } else {
    result.path = left.substr(0, dot);
    result.attribute = left.substr(dot + 1);
    if (result.path.empty() || result.path[0] != '/') result.path = "/" + result.path;
  }
  if (result.attribute.empty()) throw std::invalid_argument(inQuotes(text) + " names no attribute: " + expected);
  return result;
}

namespace {

constexpr std::string_view written_as = "--set ";

/// Every path of the scene and what it leads to.
struct Places {
  std::vector<std::string> paths;
  std::vector<std::vector<AttributeDescription>*> attributes;

  void collect(NodeDescription& node, const std::string& path) {
    const std::vector<std::string> components = componentNames(node), children = childNames(node);
    for (std::size_t i = 0; i < components.size(); ++i)
      add(joinPath(path, components[i]), node.components[i].attributes);
    add(path, node.attributes);
    for (std::size_t i = 0; i < children.size(); ++i) collect(node.children[i], joinPath(path, children[i]));
  }
  void add(std::string path, std::vector<AttributeDescription>& list) {
    paths.push_back(std::move(path));
    attributes.push_back(&list);
  }
  std::vector<AttributeDescription>* find(const std::string& path) const {
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (paths[i] == path) return attributes[i];
    return nullptr;
  }
};

}  // namespace

bool isOverride(const SourceLocation& where) { return where.line == 0 && where.file.starts_with(written_as); }

void applyOverrides(const std::vector<Override>& overrides, NodeDescription& root, Diagnostics& diagnostics) {
  if (overrides.empty()) return;
  Places places;
  places.collect(root, "/");
  const std::string root_name = root.name().empty() ? "root" : root.name();
  for (const Override& change : overrides) {
    const SourceLocation where{std::string(written_as) + change.path + "." + change.attribute, 0, 0};
    std::vector<AttributeDescription>* attributes = places.find(change.path);
    if (!attributes && change.path == "/" + root_name) attributes = places.find("/");
    if (!attributes && change.path.starts_with("/" + root_name + "/"))
      attributes = places.find(change.path.substr(root_name.size() + 1));
    if (!attributes) {
      diagnostics.error(where, change.path, "the scene has no node or component of this path", {},
                        nearest(change.path, places.paths));
      continue;
    }
    AttributeDescription given{change.attribute, change.value, where};
    std::erase_if(*attributes, [&](const AttributeDescription& other) {
      if (other.name != change.attribute) return false;
      given.overridden = isOverride(other.where) ? other.overridden : other.where;
      return true;
    });
    attributes->push_back(std::move(given));
  }
}

}  // namespace stroma
