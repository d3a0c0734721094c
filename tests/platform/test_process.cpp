// SPDX-License-Identifier: LGPL-2.1-or-later
// Other programs in processes of their own: what they have of this one, and how it is told that one cannot be started.
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "tests/support/folder_fixture.h"
#include "tools/platform/process.h"

namespace stroma::test {
namespace {

std::string textOf(const std::string& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::errc failureOf(const Program& program) try {
  exitCodeOf(start(program));
  return {};
} catch (const std::system_error& error) {
  return std::errc(error.code().value());
}

class Process : public FolderTest {};

}  // namespace

TEST_F(Process, EndsWithItsCodeOrThatOfItsSignal) {
  EXPECT_EQ(exitCodeOf(start({{"true"}})), 0);
  EXPECT_EQ(exitCodeOf(start({{"sh", "-c", "exit 7"}})), 7);
  EXPECT_EQ(exitCodeOf(start({{"sh", "-c", "kill -TERM $$"}})), 128 + SIGTERM);
}

TEST_F(Process, ThatCannotBeStartedIsAnError) {
  EXPECT_EQ(failureOf({{"no-program-has-this-name"}}), std::errc::no_such_file_or_directory);
  EXPECT_EQ(failureOf({{"/etc/passwd"}}), std::errc::permission_denied);
  EXPECT_EQ(failureOf({{"true"}, "/no/folder"}), std::errc::no_such_file_or_directory);
  EXPECT_EQ(failureOf({{"true"}, {}, {}, {}, "/no/folder/log"}), std::errc::no_such_file_or_directory);
}

TEST_F(Process, HasTheFolderAndTheStreamsThatItIsGiven) {
  write("read", "a line\n");
  Program program{{"sh", "-c", "cat; pwd; echo no >&2"}, folder_.string()};
  program.input = "read", program.output = "output", program.errors = "errors";
  ASSERT_EQ(exitCodeOf(start(program)), 0);
  EXPECT_EQ(textOf(file("output")), "a line\n" + std::filesystem::canonical(folder_).string() + "\n");
  EXPECT_EQ(textOf(file("errors")), "no\n");
}

/// Of a parent that has closed its own streams, as a service may.
TEST_F(Process, HasItsStreamsAlsoWhereThisOneHasNone) {
  write("read", "a line\n");
  Program reads{{"cat"}}, is_none{{"no-program-has-this-name"}};
  for (Program* program : {&reads, &is_none}) program->input = file("read"), program->output = file("output");
  const int input = dup(STDIN_FILENO), output = dup(STDOUT_FILENO);
  close(STDIN_FILENO), close(STDOUT_FILENO);
  const int code = exitCodeOf(start(reads));
  const std::string text = textOf(file("output"));
  const std::errc failure = failureOf(is_none);
  dup2(input, STDIN_FILENO), dup2(output, STDOUT_FILENO);
  close(input), close(output);
  EXPECT_EQ(code, 0);
  EXPECT_EQ(text, "a line\n");
  EXPECT_EQ(failure, std::errc::no_such_file_or_directory);
}

TEST_F(Process, HasNoSignalBlockedAndTheNameThatItIsGiven) {
  sigset_t term, before;
  sigemptyset(&term), sigaddset(&term, SIGTERM);
  sigprocmask(SIG_BLOCK, &term, &before);
  Program program{{"its-name", "-c", "echo $0; kill -TERM $$; exit 3"}};
  program.file = "sh", program.output = file("output");
  const int code = exitCodeOf(start(program));
  sigprocmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(code, 128 + SIGTERM);
  EXPECT_EQ(textOf(file("output")), "its-name\n");
}

TEST_F(Process, RunsOnTheCoresThatItIsGiven) {
  cpu_set_t cores;
  ASSERT_EQ(sched_getaffinity(0, sizeof cores, &cores), 0);
  int last = CPU_SETSIZE - 1;
  while (!CPU_ISSET(last, &cores)) --last;
  Program program{{"grep", "Cpus_allowed_list", "/proc/self/status"}};
  program.cores = {last}, program.output = file("output");
  ASSERT_EQ(exitCodeOf(start(program)), 0);
  EXPECT_EQ(textOf(file("output")), "Cpus_allowed_list:\t" + std::to_string(last) + "\n");
}

}  // namespace stroma::test
