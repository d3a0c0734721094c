// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene's XML on its way to components: any text is refused with sentences, or becomes a tree that reads back from what
// writeXml() makes of it.
#include "framework/scene/load.h"
#include "tests/fuzz/every_attribute.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/xml_writer.h"

namespace {

using namespace stroma;

Factory& factory() {
  static Factory instance = [] {
    Factory made;
    made.add<fuzz::EveryAttribute>("Every", "has an attribute of each type");
    return made;
  }();
  return instance;
}

void readsBack(const NodeDescription& root) {
  const std::string written = writeXml(root);
  Diagnostics diagnostics;
  const NodeDescription again = readXml(written, "again.xml", {}, diagnostics);
  fuzz::require(!diagnostics.hasErrors(), "what was written cannot be read: " + diagnostics.text() + written);
  fuzz::require(writeXml(again) == written, "what was written reads back as another tree:\n" + written);
}

}  // namespace

STROMA_FUZZ_TARGET(scene) {
  static Modules modules(factory(), {});
  const std::string text(reinterpret_cast<const char*>(data), size);
  Diagnostics diagnostics;
  const NodeDescription root = readXml(text, "fuzz.xml", {}, diagnostics);
  if (!diagnostics.hasErrors()) readsBack(root);
  try {
    loadSceneText(text, "fuzz.xml", {}, factory(), modules);
  } catch (const SceneError& error) {
    fuzz::require(error.diagnostics().hasErrors(), "refused without a sentence");
  }
  return 0;
}
