// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/mesh_chain.h"

#include <algorithm>
#include <vector>

#include "framework/mechanics/state_topology.h"
#include "framework/scene/load.h"
#include "framework/scene/names.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

constexpr int longest_chain = 8;

}  // namespace

Place placeOf(NodeDescription& root, std::string path) {
  NodeDescription* node = &root;
  path.erase(0, 1);
  for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/')) {
    const std::vector<std::string> names = childNames(*node);
    const auto found = std::find(names.begin(), names.end(), path.substr(0, slash));
    if (found == names.end()) return {};
    node = &node->children[std::size_t(found - names.begin())];
    path.erase(0, slash + 1);
  }
  const std::vector<std::string> names = componentNames(*node);
  const auto found = std::find(names.begin(), names.end(), path);
  return found == names.end() ? Place{} : Place{node, std::size_t(found - names.begin())};
}

TopologicalMapping* fillerOf(const Topology& topology) {
  std::vector<TopologicalMapping*> mappings;
  topology.node().root().collect(mappings);
  const auto found =
      std::find_if(mappings.begin(), mappings.end(), [&](const auto* each) { return each->output() == &topology; });
  return found == mappings.end() ? nullptr : *found;
}

const Topology* inputOf(const TopologicalMapping& mapping) {
  const Data* input = mapping.data().find("input");
  if (input && input->link() && input->link()->target()) return dynamic_cast<const Topology*>(input->link()->target());
  for (const Node* node = mapping.node().parent(); node; node = node->parent()) {
    const Topology* last = nullptr;
    for (const auto& near : node->components())
      if (const auto* topology = dynamic_cast<const Topology*>(near.get()); topology && topology->answersLookup())
        last = topology;
    if (last) return last;
  }
  return nullptr;
}

/// What "@path" or "@path.attribute" names, from the node of a component.
Component* MeshChain::targetOf(const Component& component, const std::string& link) const {
  std::string at = component.path().substr(0, component.path().rfind('/')), path(trimmed(link).substr(1));
  if (path.starts_with("/")) at.clear(), path.erase(0, 1);
  for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/')) {
    const std::string step = path.substr(0, slash);
    path.erase(0, slash + 1);
    if (step == "..")
      at.erase(std::min(at.size(), at.rfind('/')));
    else if (step != "." && !step.empty())
      at += "/" + step;
  }
  path.erase(std::min(path.size(), path.find('.')));
  return path.empty() ? nullptr : findComponent(root_, at + "/" + path);
}

bool MeshChain::leadsThere(const Topology& part, int depth) const {
  if (&part == &whole_) return true;
  if (depth > longest_chain) return false;
  const auto* mapping = dynamic_cast<const TopologicalMapping*>(&part);
  if (!mapping) mapping = fillerOf(part);
  if (mapping) {
    const Topology* input = inputOf(*mapping);
    return input && input != &part && leadsThere(*input, depth + 1);
  }
  const Place at = placeOf(description_, part.path());
  if (!at.node) return false;
  return std::any_of(at.written().attributes.begin(), at.written().attributes.end(), [&](const AttributeDescription& each) {
    if (!trimmed(each.value).starts_with("@")) return false;
    const auto* source = dynamic_cast<const Topology*>(targetOf(part, each.value));
    return source && source != &part && leadsThere(*source, depth + 1);
  });
}

bool MeshChain::isMadeOf(const Topology& part) const {
  return &part == &whole_ || (leadsThere(part, 0) && part.mesh().position == whole_.mesh().position);
}

bool MeshChain::reaches(const Component& component, int depth) const {
  if (depth > longest_chain) return false;
  if (const auto* topology = dynamic_cast<const Topology*>(&component)) return leadsThere(*topology, depth);
  if (const auto* state = dynamic_cast<const State*>(&component)) {
    const std::vector<const Topology*> all = topologiesOf(*state);
    if (std::any_of(all.begin(), all.end(), [&](const Topology* each) { return leadsThere(*each, depth); })) return true;
  }
  const Place at = placeOf(description_, component.path());
  if (!at.node) return false;
  return std::any_of(at.written().attributes.begin(), at.written().attributes.end(), [&](const AttributeDescription& each) {
    if (!trimmed(each.value).starts_with("@")) return false;
    const Component* target = targetOf(component, each.value);
    return target && target != &component && reaches(*target, depth + 1);
  });
}

}  // namespace stroma
