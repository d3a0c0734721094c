// SPDX-License-Identifier: LGPL-2.1-or-later
// What SOFA computes in its own way, one flag each. A scene in SOFA's dialect has all of them, unless `withoutQuirks` of its
// outermost node names some.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/data.h"

namespace stroma::sofa {

/// An attribute that stands for a quirk in a native scene.
struct QuirkPart {
  std::string_view types;  ///< of components, with blanks between; "*": all that have the attribute; "Node": of nodes
  std::string_view attribute;
  std::string_view value;  ///< empty: it depends on the scene
};
struct Quirk {
  std::string_view name, what;
  std::vector<QuirkPart> parts;
};
const std::vector<Quirk>& allQuirks();
std::vector<std::string> quirkNames();
bool concerns(const QuirkPart& part, std::string_view type, const DataTable& attributes);

/// Those of one scene, and what each of them changed.
class Quirks {
 public:
  void switchOff(const std::string& name) { off_.push_back(name); }
  /// Whether it is on; `path` is then counted as changed by it.
  bool use(std::string_view name, const std::string& path);
  bool isOn(std::string_view name) const;
  /// "cg-threshold: ... (2 components, the first is /cg)", and those that are off.
  std::vector<std::string> lines() const;

 private:
  std::vector<std::string> off_;
  std::map<std::string, std::vector<std::string>, std::less<>> used_;
};

}  // namespace stroma::sofa
