// SPDX-License-Identifier: LGPL-2.1-or-later
// Every component's manual page has an example, and every example runs.
#include <algorithm>
#include <map>
#include <vector>

#include "framework/scene/modules.h"
#include "tests/support/manual_examples.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using ManualExamples = CommandTest;

TEST_F(ManualExamples, EveryComponentHasOneAndItRuns) {
  Factory factory;
  const Modules modules(factory);
  ASSERT_FALSE(modules.index().empty());
  std::map<std::string, std::vector<std::string>> types_of;  // several names of one component share a page
  for (const auto& entry : modules.index()) {
    const std::string type(entry.type);
    const std::string example = exampleIn(modules.manual(type));
    EXPECT_FALSE(example.empty()) << type << " has no example in its manual page";
    if (!example.empty()) types_of[example].push_back(type);
  }
  std::filesystem::create_directory_symlink(STROMA_SOURCE_DIR "/scenes", folder_ / "scenes");
  writeExampleFiles(folder_ / "meshes");
  for (const auto& [example, types] : types_of) {
    const auto isInExample = [&text = example](const auto& type) { return text.find("<" + type) != text.npos; };
    EXPECT_TRUE(std::ranges::any_of(types, isInExample))
        << types[0] << " does not occur in its example";
    write("example.xml", example);
    const Finished run = stroma("run example.xml -n 3 --quiet");
    EXPECT_EQ(run.code, 0) << types[0] << ":\n" << run.err << example;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
