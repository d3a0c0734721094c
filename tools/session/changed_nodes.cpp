// SPDX-License-Identifier: LGPL-2.1-or-later
// Changes of meshes rewrite components, leave some out and add some; nodes stay what they are. So a node is known by its number in
// the order of the file, and a component that no change concerns by its number in the first list of its node: it keeps what the
// scene gives it when the run goes on.
#include "tools/session/changed_nodes.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "framework/scene/data.h"

namespace stroma {
namespace {

template <class Description>
void collect(Description& node, std::vector<Description*>& nodes) {
  nodes.push_back(&node);
  for (auto& child : node.children) collect(child, nodes);
}

std::string textOf(const AttributeDescription& attribute) { return attribute.typed ? attribute.typed->print() : attribute.value; }

bool areTheSame(const ComponentDescription& a, const ComponentDescription& b) {
  return a.type == b.type && std::equal(a.attributes.begin(), a.attributes.end(), b.attributes.begin(), b.attributes.end(),
                                        [](const AttributeDescription& one, const AttributeDescription& other) {
                                          return one.name == other.name && one.value == other.value && one.typed == other.typed;
                                        });
}

/// Of each component now: its number in the first list, or -1.
std::vector<int> originsOf(const NodeDescription& first, const NodeDescription& now) {
  std::vector<int> origins;
  std::vector<bool> is_used(first.components.size(), false);
  for (const ComponentDescription& component : now.components) {
    origins.push_back(-1);
    for (std::size_t i = 0; i < first.components.size() && origins.back() < 0; ++i)
      if (!is_used[i] && areTheSame(first.components[i], component)) is_used[i] = true, origins.back() = int(i);
  }
  return origins;
}

/// A check sum of what the list of a node was: of components that stay what they are called, of all others the whole.
long sumOf(const NodeDescription& node, const std::vector<int>& kept) {
  std::string text;
  for (std::size_t i = 0; i < node.components.size(); ++i) {
    const ComponentDescription& component = node.components[i];
    const bool stays = std::count(kept.begin(), kept.end(), int(i)) > 0;
    text += component.type + "\n" + component.name() + "\n";
    for (const AttributeDescription& attribute : component.attributes)
      if (!stays) text += attribute.name + "=" + textOf(attribute) + "\n";
  }
  return long(crc32_z(0, reinterpret_cast<const unsigned char*>(text.data()), text.size()));
}

void visit(Archive& archive, const std::string& name, SourceLocation& where) {
  archive.value(name + "file", where.file);
  archive.value(name + "line", where.line);
  archive.value(name + "column", where.column);
}

void visit(Archive& archive, const std::string& name, ComponentDescription& component) {
  archive.value(name + "type", component.type);
  archive.value(name + "folder", component.folder);
  visit(archive, name, component.where);
  std::size_t count = component.attributes.size();
  archive.value(name + "attributes", count);
  component.attributes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    AttributeDescription& attribute = component.attributes[i];
    const std::string of_it = fmt::format("{}{} ", name, i);
    std::string text = archive.isReading() ? "" : textOf(attribute);
    archive.value(of_it + "name", attribute.name);
    archive.value(of_it + "value", text);
    if (archive.isReading()) attribute.value = std::move(text);
    visit(archive, of_it, attribute.where);
    visit(archive, of_it + "overridden ", attribute.overridden);
  }
}

std::string placeOf(const NodeDescription& node) { return node.where.text().empty() ? "a node" : "the node at " + node.where.text(); }

}  // namespace

void writeChangedNodes(const NodeDescription& first, const NodeDescription& now, Archive& archive) {
  std::vector<const NodeDescription*> before, after;
  collect(first, before), collect(now, after);
  std::vector<int> changed;
  for (std::size_t n = 0; n < std::min(before.size(), after.size()); ++n) {
    std::vector<int> origins = originsOf(*before[n], *after[n]);
    const bool is_same = origins.size() == before[n]->components.size() && std::is_sorted(origins.begin(), origins.end()) &&
                         std::count(origins.begin(), origins.end(), -1) == 0;
    if (is_same) continue;
    changed.push_back(int(n));
    const std::string name = fmt::format("{} ", n);
    long sum = sumOf(*before[n], origins);
    archive.value(name + "sum", sum);
    archive.list(name + "origins", origins);
    for (std::size_t c = 0; c < origins.size(); ++c)
      if (origins[c] < 0) {
        ComponentDescription component = after[n]->components[c];
        visit(archive, fmt::format("{}{} ", name, c), component);
      }
  }
  archive.list("nodes", changed);
}

void readChangedNodes(Archive& archive, NodeDescription& root) {
  std::vector<NodeDescription*> nodes;
  collect(root, nodes);
  std::vector<int> changed;
  archive.list("nodes", changed);
  for (const int n : changed) {
    if (n < 0 || std::size_t(n) >= nodes.size())
      throw std::runtime_error("the scene has fewer nodes than when its meshes changed");
    NodeDescription& node = *nodes[std::size_t(n)];
    const std::string name = fmt::format("{} ", n);
    long sum = 0;
    std::vector<int> origins;
    archive.value(name + "sum", sum);
    archive.list(name + "origins", origins);
    if (sum != sumOf(node, origins))
      throw std::runtime_error(
          placeOf(node) + " has other components or attributes than when its mesh changed (expected the scene, and the values of "
                          "--set, that the run began with)");
    std::vector<ComponentDescription> components(origins.size());
    for (std::size_t c = 0; c < origins.size(); ++c) {
      if (origins[c] >= 0)
        components[c] = node.components.at(std::size_t(origins[c]));
      else
        visit(archive, fmt::format("{}{} ", name, c), components[c]);
    }
    node.components = std::move(components);
  }
}

}  // namespace stroma
