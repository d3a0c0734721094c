// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/attribute_text.h"

#include <fmt/format.h>

namespace stroma::command {

std::string traitsOf(const Data& data) {
  std::string text = data.typeText();
  if (!data.unitText().empty() && data.unitText() != "-") text += " [" + data.unitText() + "]";
  if (data.isOutput()) return text + ", computed";
  if (data.isRequired()) {
    text += ", required";
  } else {
    text += data.defaultText().empty() ? ", empty by default" : ", default " + data.defaultText();
  }
  if (!data.rangeText().empty()) text += ", in " + data.rangeText();
  if (data.changeEffect() == ChangeEffect::at_once) text += ", may change in a run";
  if (data.changeEffect() == ChangeEffect::recompile) text += ", may change in a run (the component is recompiled)";
  return text;
}

std::string helpOf(const Data& data) {
  std::string text = data.helpText() + "\n" + traitsOf(data);
  if (data.aliases().empty()) return text;
  return text + fmt::format("; also called {}", fmt::join(data.aliases(), ", "));
}

}  // namespace stroma::command
