// SPDX-License-Identifier: LGPL-2.1-or-later
// What a shell offers where the cursor is: asked of the command, and of bash, zsh and fish themselves.
#include <regex>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr const char* beam =
    "<Node name='root' dt='0.01'><RegularGridTopology name='grid' n='3 3 3' min='0 0 0' max='1 1 1'/>"
    "<Node name='beam'><MechanicalObject name='dofs'/><HexahedronFEMForceField name='fem' "
    "method='polar'/></Node></Node>";

class Completion : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("beam.xml", beam);
    write("beans.txt", "no scene");
    write("broken.xml", "<Node><Nod");
    std::filesystem::create_directory(folder_ / "bed");
    std::filesystem::create_symlink(STROMA_COMMAND, folder_ / "stroma");
    for (const char* shell : {"bash", "zsh", "fish"})
      write(std::string("script.") + shell, stroma(std::string("completion ") + shell).out);
  }
  /// The answers, a line each, without descriptions.
  std::string asked(const std::string& words) const {
    const Finished answer = stroma("__complete " + words);
    EXPECT_EQ(answer.code, 0) << words;
    EXPECT_EQ(answer.err, "") << words;
    return std::regex_replace(answer.out, std::regex("\t[^\n]*"), "");
  }
  /// The same of a shell that runs `program` in the folder of the test.
  std::string said(const std::string& shell_line, const std::string& program) const {
    write("test.sh", program);
    const Finished finished = shell("PATH=\"$PWD:$PATH\" " + shell_line + " test.sh");
    EXPECT_EQ(finished.err, "");
    return finished.out;
  }
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// ---- the answers ----

TEST_F(Completion, SubcommandsOptionsAndValues) {
  EXPECT_EQ(asked("ru"), "=run\n");
  EXPECT_FALSE(has(asked("''"), "__complete"));
  EXPECT_TRUE(has(stroma("__complete ch").out, "=check\treport every problem"));
  EXPECT_EQ(asked("run --rec"), "=--record\n=--record-every\n");
  EXPECT_TRUE(has(stroma("__complete run --until").out, "=--until\trun to this time"));
  EXPECT_EQ(asked("run ''"), "f*.xml *.scn *.py\n");
  EXPECT_EQ(asked("run --module ''"), "f*.so\n");
  EXPECT_EQ(asked("run --record ''"), "d\n");
  EXPECT_EQ(asked("run beam.xml -n ''"), "");
  EXPECT_EQ(asked("run --json=''"), "f*\n");
  EXPECT_EQ(asked("run --json ''"), "f*.xml *.scn *.py\n") << "its value follows = only";
  EXPECT_EQ(asked("view beam.xml --export ''"), "f*.html\n");
  EXPECT_EQ(asked("completion ''"), "=bash\n=zsh\n=fish\n");
  EXPECT_EQ(asked("help reg"), "=regress\n");
  EXPECT_EQ(asked("doc CondensedS"), "=CondensedStaticSolver\n");
  EXPECT_EQ(asked("doc contac"), "=contact\n");
  EXPECT_EQ(asked("nonsense ''"), "");
  EXPECT_EQ(asked(""), "");
}

TEST_F(Completion, SettingsComeFromTheSceneOnTheLine) {
  EXPECT_EQ(asked("run beam.xml --set ''"), "+gravity=\n+dt=\n+time=\n+/beam/\n+/grid.\n");
  EXPECT_EQ(asked("run beam.xml --set /beam/"), "+/beam/dofs.\n+/beam/fem.\n");
  EXPECT_EQ(asked("run beam.xml --set beam/f"), "+beam/fem.\n");
  EXPECT_EQ(asked("run beam.xml --set /beam/fem.young"), "+/beam/fem.youngModulus=\n");
  EXPECT_EQ(asked("run beam.xml --set=/beam/fem.method=sv"), "=--set=/beam/fem.method=svd\n");
  EXPECT_EQ(asked("run beam.xml --set /beam.gra"), "+/beam.gravity=\n");
  EXPECT_EQ(asked("check --set dt=0.1 beam.xml --set /beam/fem.updateVolume="),
            "=/beam/fem.updateVolume=true\n=/beam/fem.updateVolume=false\n");
  EXPECT_TRUE(has(stroma("__complete run beam.xml --set /beam/fem.meth").out, "=\t[polar] "));
  for (const char* words : {"broken.xml --set /", "absent.xml --set /", "bed --set /", "beam.xml --set /none/",
                            "beam.xml --set /none.x", "beam.xml --set /grid.none=", "--set /"})
    EXPECT_EQ(asked(std::string("run ") + words), "") << words;
}

TEST_F(Completion, OnlyPlainNamesOfASceneAreOffered) {
  for (const char* name : {"$(touch PWNED)", "`touch PWNED`", "two words", ";ls", "a&amp;b", "a|b", "a&#10;=/evil",
                           "a&#9;b", "&#27;[31m", "&quot;", "\\", "*", "~root", "{a,b}", "!!", "#no",
                           "a\xC2\x9B"
                           "b"}) {
    write("hostile.xml", std::string("<Node><Node name=\"") + name + "\"/><Node name=\"plain_1-a\"/></Node>");
    EXPECT_EQ(asked("run hostile.xml --set /"), "+/plain_1-a/\n") << name;
    write("hostile.xml",
          std::string("<Node><HexahedronFEMForceField name='fem' youngModulus=\"") + name + "\"/></Node>");
    const std::string value = asked("run hostile.xml --set /fem.youngModulus=");
    EXPECT_TRUE(value.empty() || value == "=/fem.youngModulus=5000\n") << value;  // the default, at most
    const std::string beside = stroma("__complete run hostile.xml --set /fem.youngM").out;
    EXPECT_EQ(std::count(beside.begin(), beside.end(), '\n'), 1) << beside;
    EXPECT_FALSE(has(beside, "\x1B") || has(beside, "\xC2\x9B")) << beside;
  }
}

TEST_F(Completion, APipeIsNotWaitedFor) {
  ASSERT_EQ(shell("mkfifo pipe.xml").code, 0);
  write("waits.xml", "<Node><include href='pipe.xml'/></Node>");
  const Finished asked = shell("timeout 600 ./stroma __complete run waits.xml --set /");
  EXPECT_EQ(asked.code, 0);
  EXPECT_EQ(asked.out, "");
  EXPECT_EQ(shell("timeout 600 ./stroma __complete run pipe.xml --set /").code, 0);
  const Finished check = shell("timeout 600 ./stroma check waits.xml");
  EXPECT_EQ(check.code, 2);
  EXPECT_TRUE(has(check.out + check.err, "pipe.xml cannot be read")) << check.out << check.err;
}

// ---- the shells ----

/// A scene with names that a shell would run, beside a good one.
constexpr const char* hostile =
    "<Node><Node name='$(touch PWNED)'/><Node name='`touch PWNED`'/><Node name=';touch PWNED;'/><Node name='two "
    "words'/>"
    "<Node name='a&#10;+/$(touch PWNED)'/><Node name='good'/></Node>";

/// Completes a line as bash does, which replaces what stands behind a blank, = or :. An interactive bash is in
/// test_completion_in_bash.py.
constexpr const char* bash_harness = R"(
source script.bash
answers() {
  COMP_LINE=$1 COMP_POINT=${#1}
  _stroma stroma "${1##*[ =:]}" ""
  echo "${COMPREPLY[*]}"
}
)";

TEST_F(Completion, BashOffersIt) {
  if (!isInstalled("bash")) GTEST_SKIP() << "there is no bash";
  const std::pair<const char*, const char*> cases[] = {
      {"stroma ru", "run"},
      {"stroma run b", "beam.xml bed broken.xml"},
      {"stroma run --rec", "--record --record-every"},
      {"stroma run --record b", "bed"},
      {"stroma run --json=bea", "beam.xml beans.txt"},
      {"stroma run beam.xml --set /beam/fem.young", "/beam/fem.youngModulus="},
      {"stroma run beam.xml --set /beam/fem.method=sv", "svd"},
      {"stroma run beam.xml --set=/beam/fem.method=sv", "svd"},
      {"stroma run broken.xml --set /", ""}};
  for (const auto& [line, expected] : cases) {
    std::string program = bash_harness;
    // files come in the order of the folder
    program += std::string("answers '") + line + "' | tr ' ' '\\n' | LC_ALL=C sort | paste -sd ' '\n";
    EXPECT_EQ(said("bash --norc", program), std::string(expected) + "\n") << line;
  }
}

TEST_F(Completion, FishOffersIt) {
  if (!isInstalled("fish")) GTEST_SKIP() << "there is no fish";
  const std::pair<const char*, const char*> cases[] = {
      {"stroma ru", "run\tsimulate a scene\n"},
      {"stroma run bea", "beam.xml\n"},
      {"stroma run --json=beam", "--json=beam.xml\n"},
      {"stroma run --until", "--until\trun to this time [s] instead\n"},
      {"stroma run beam.xml --set=/beam/fem.method=sv", "--set=/beam/fem.method=svd\n"},
      {"stroma run beam.xml --set /beam/f", "/beam/fem.\tHexahedronFEMForceField\n"},
      {"stroma run broken.xml --set /", ""}};
  for (const auto& [line, expected] : cases)
    EXPECT_EQ(said("HOME=\"$PWD\" fish --no-config", std::string("source script.fish\ncomplete -C '") + line + "'\n"),
              expected)
        << line;
}

/// Types a line and a tab into a zsh of its own, and prints what the line has become.
constexpr const char* zsh_harness = R"(
zmodload zsh/zpty
zpty shell zsh -f -i || { print -u2 'no pseudo-terminal: is /dev/pts mounted?'; exit 1; }
zpty -w shell 'PS1=; autoload -Uz compinit; compinit -u -D; source script.zsh; stty -echo columns 300; bindkey "^I" complete-word
  keep() { print -r -- "$BUFFER" >line.txt; zle kill-whole-line; }; zle -N keep; bindkey "^O" keep; print READ''Y'
zpty -r shell said '*READY*'
rm -f line.txt
zpty -w -n shell "$LINE_TO_COMPLETE"$'\t\x0f'
for try in {1..12000}; do [[ -s line.txt ]] && break; sleep 0.05; done
cat line.txt
zpty -d shell
)";

TEST_F(Completion, ZshOffersIt) {
  if (!isInstalled("zsh")) GTEST_SKIP() << "there is no zsh";
  const std::pair<const char*, const char*> cases[] = {
      {"stroma comp", "stroma completion "},
      {"stroma run bea", "stroma run beam.xml "},
      {"stroma run --unt", "stroma run --until "},
      {"stroma run --json=beam", "stroma run --json=beam.xml "},
      {"stroma run --record be", "stroma run --record bed/"},
      {"stroma run beam.xml --set /beam/fem.young", "stroma run beam.xml --set /beam/fem.youngModulus="},
      {"stroma run beam.xml --set=/beam/fem.method=sv", "stroma run beam.xml --set=/beam/fem.method=svd "},
      {"stroma run broken.xml --set /", "stroma run broken.xml --set /"}};
  for (const auto& [line, expected] : cases)
    EXPECT_EQ(said("zsh -f", std::string("LINE_TO_COMPLETE='") + line + "'\n" + zsh_harness),
              std::string(expected) + "\n")
        << line;
}

TEST_F(Completion, NoShellRunsANameOfAScene) {
  write("hostile.xml", hostile);
  const std::string line = "stroma run hostile.xml --set /", good = "/good/";
  if (isInstalled("bash")) EXPECT_EQ(said("bash --norc", bash_harness + ("answers '" + line + "'\n")), good + "\n");
  if (isInstalled("fish"))
    EXPECT_EQ(said("HOME=\"$PWD\" fish --no-config", "source script.fish\ncomplete -C '" + line + "'\n"),
              good + "\tnode\n");
  if (isInstalled("zsh"))
    EXPECT_EQ(said("zsh -f", "LINE_TO_COMPLETE='" + line + "'\n" + zsh_harness),
              "stroma run hostile.xml --set " + good + "\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "PWNED"));
}

TEST_F(Completion, AnotherShellIsRefused) {
  const Finished finished = stroma("completion tcsh");
  EXPECT_EQ(finished.code, 2);
  EXPECT_TRUE(has(finished.err, "expected bash, zsh or fish")) << finished.err;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
