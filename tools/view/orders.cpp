// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

namespace stroma::view {
namespace {

using nlohmann::json;

/// What a page may ask for, and what it may say with it besides "do", "request" and "sequence".
const std::map<std::string, std::vector<std::string>>& verbs() {
  static const std::map<std::string, std::vector<std::string>> table{
      {"hello", {"build"}},
      {"want", {"nodes", "fields", "loads", "contacts", "format", "fps"}},
      {"watch", {"values"}},
      {"drawn", {"frame"}},
      {"control", {}},
      {"run", {}},
      {"pause", {}},
      {"step", {"count"}},
      {"reset", {}},
      {"pace", {"pace", "factor"}},
      {"seek", {"index"}},
      {"pull", {"hand", "kind", "body", "nodes", "frames", "targets", "stiffness", "generation"}},
      {"force", {"hand", "body", "nodes", "force", "generation"}},
      {"push", {"hand", "body", "centre", "radius", "stiffness", "generation"}},
      {"release", {"hand"}},
      {"move", {"hand", "obstacle", "offset"}},
      {"key", {"key", "pressed"}},
      {"mouse", {"state", "x", "y", "wheel"}},
      {"set", {"path", "attribute", "value"}},
      {"components", {}},
      {"explain", {}},
      {"xml", {}},
      {"actions", {}},
      {"doubts", {}},
      {"hash", {}}};
  return table;
}

}  // namespace

std::string checkedVerb(const json& order) {
  const std::string verb = text(member(order, "do"), "do", 20);
  const auto known = verbs().find(verb);
  if (known == verbs().end()) {
    std::vector<std::string> names;
    for (const auto& [name, members] : verbs()) names.push_back(name);
    throw ComponentError("there is nothing to do that is called '" + verb + "'",
                         fmt::format("{}", fmt::join(names, ", ")), nearest(verb, names));
  }
  std::vector<std::string> allowed = known->second;
  for (const char* always : {"do", "request", "sequence"}) allowed.emplace_back(always);
  for (const auto& item : order.items())
    if (std::find(allowed.begin(), allowed.end(), item.key()) == allowed.end())
      throw ComponentError("'" + verb + "' has no '" + item.key().substr(0, 40) + "'",
                           fmt::format("{}", fmt::join(allowed, ", ")), nearest(item.key(), allowed));
  return verb;
}

bool needsControl(const std::string& verb) {
  for (const char* free : {"components", "explain", "xml", "actions", "hash", "doubts"})
    if (verb == free) return false;
  return true;
}

std::string sentenceOf(const ComponentError& error) {
  std::string more;
  if (!error.expected.empty()) more = "expected " + error.expected;
  if (!error.suggestion.empty()) more += (more.empty() ? "did you mean " : "; did you mean ") + error.suggestion + "?";
  return more.empty() ? error.what() : fmt::format("{} ({})", error.what(), more);
}

}  // namespace stroma::view
