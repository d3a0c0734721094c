// SPDX-License-Identifier: LGPL-2.1-or-later
// The pages of the manual: one per subcommand, with every option of its --help, and nothing that man would complain of.
#include <regex>
#include <sstream>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class ManualPages : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    ASSERT_EQ(stroma("man --write man").code, 0);
  }
  std::vector<std::string> subcommands() const {
    std::vector<std::string> names;
    const std::string help = stroma("--help").out;
    const std::regex line("\n  ([a-z]+) +[a-z]");
    for (std::sregex_iterator at(help.begin(), help.end(), line), end; at != end; ++at) names.push_back((*at)[1]);
    return names;
  }
  std::vector<std::filesystem::path> pages() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "man"))
      if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
  }
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(ManualPages, EverySubcommandHasOneWithItsOptions) {
  const auto names = subcommands();
  EXPECT_GE(names.size(), 12u);
  for (const std::string& name : names) {
    const std::string page = readText(folder_ / "man/man1" / ("stroma-" + name + ".1"));
    EXPECT_TRUE(has(page, "\nstroma\\-" + name + " \\- ")) << name;
    EXPECT_TRUE(has(page, ".SH EXAMPLES\n")) << name;
    const std::string help = stroma(name + " --help").out;
    EXPECT_TRUE(has(help, "examples:")) << name;
    const std::regex option("\n  (?:-. \\[ )?--([a-z][a-z0-9_-]*)");
    for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at) {
      const std::string word = std::regex_replace((*at)[1].str(), std::regex("-"), "\\-");
      EXPECT_TRUE(has(page, "\\fB\\-\\-" + word + "\\fP")) << name << " --" << (*at)[1];
    }
    EXPECT_TRUE(has(readText(folder_ / "man/man1/stroma.1"), ".TP\n\\fB" + name + "\\fP\n")) << name;
  }
  EXPECT_TRUE(has(readText(folder_ / "man/man5/stroma-scene.5"), ".SH LINKS\n"));
}

TEST_F(ManualPages, ManFindsNothingWrong) {
  if (!isInstalled("man")) GTEST_SKIP() << "there is no man";
  for (const auto& page : pages()) {
    const Finished shown = shell("MANWIDTH=80 man --warnings -E UTF-8 -l '" + page.string() + "'");
    EXPECT_EQ(shown.err, "") << page;
    EXPECT_TRUE(has(shown.out, "NAME\n")) << page;
    if (!isInstalled("mandoc")) continue;
    EXPECT_EQ(shell("mandoc -Tlint '" + page.string() + "'").out, "") << page;
  }
}

/// Each name under FILES is that of a file which the runs below leave.
TEST_F(ManualPages, FilesThatItNamesAreWritten) {
  write("organ.xml",
        "<Node><EulerImplicitSolver/><CGLinearSolver/><MechanicalObject name='dofs' position='0 0 0'/>"
        "<UniformMass totalMass='1'/></Node>");
  ASSERT_EQ(stroma("run organ.xml -n 2").code, 0);
  ASSERT_EQ(stroma("run organ.xml -n 2 --record kept").code, 0);
  const std::string page = readText(folder_ / "man/man1/stroma.1");
  const auto start = page.find(".SH FILES\n"), end = page.find("\n.SH ", start + 1);
  const std::string files = page.substr(start, end - start);
  const std::regex tag("\n\\.TP\n\\\\fB(.*)\\\\fP\n");
  int named = 0;
  for (std::sregex_iterator at(files.begin(), files.end(), tag), none; at != none; ++at, ++named) {
    std::string name = std::regex_replace((*at)[1].str(), std::regex("SCENE|STEM"), "organ");
    name = std::regex_replace(name, std::regex("^DIR"), "kept");
    const std::filesystem::path path = folder_ / name;
    const bool is_any = path.filename() == "NAME.state.gz";
    bool is_there = !is_any && std::filesystem::exists(path);
    for (const auto& entry : std::filesystem::directory_iterator(path.parent_path()))
      is_there = is_there || (is_any && entry.path().filename().string().ends_with(".state.gz"));
    EXPECT_TRUE(is_there) << name << " is not written";
  }
  EXPECT_GE(named, 4);
}

TEST_F(ManualPages, AFolderThatCannotBeMadeIsASentence) {
  write("taken", "a file");
  const Finished refused = stroma("man --write taken");
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(has(refused.err, "cannot make the folder")) << refused.err;
  EXPECT_FALSE(has(refused.err, "filesystem error")) << refused.err;
}

TEST_F(ManualPages, OnePageIsPrinted) {
  EXPECT_EQ(stroma("man run").out, readText(folder_ / "man/man1/stroma-run.1"));
  EXPECT_EQ(stroma("man").out, readText(folder_ / "man/man1/stroma.1"));
  EXPECT_EQ(stroma("man scene").out, readText(folder_ / "man/man5/stroma-scene.5"));
  const Finished unknown = stroma("man rnu");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_TRUE(has(unknown.err, "did you mean 'run'?")) << unknown.err;
}

TEST_F(ManualPages, HelpAndVersionSayWhatTheCommandIs) {
  EXPECT_EQ(stroma("help").out, stroma("--help").out);
  EXPECT_EQ(stroma("help run").out, stroma("run --help").out);
  EXPECT_EQ(stroma("help rnu").code, 2);
  const std::string version = stroma("--version").out;
  for (const char* fact : {"stroma ", "compiled by ", "Eigen ", "modules: ", "licence: LGPL"})
    EXPECT_TRUE(has(version, fact)) << version;
  EXPECT_FALSE(has(stroma("--help").out, "__complete"));
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
