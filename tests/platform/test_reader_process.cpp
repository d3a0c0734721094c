// SPDX-License-Identifier: LGPL-2.1-or-later
// What becomes of a program that reads a file for us: every end is an ordinary error.
#include "framework/scene/reader_process.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "framework/scene/diagnostics.h"

namespace stroma {
namespace STROMA_TEST_FILE {

const ReaderProgram unruly{STROMA_UNRULY_READER, "the unruly reader", "build it"};

std::string errorOf(const ReaderProgram& program, const Texts& arguments) {
  try {
    readInOwnProcess(program, "folder/file.x", arguments);
  } catch (const ComponentError& error) {
    return error.what() + (" | " + error.expected) + " | " + error.suggestion;
  }
  return {};
}

TEST(ReaderProcess, HandsListsOver) {
  const ValueLists lists = readInOwnProcess(unruly, "file.x", {"good", "", "two words\n"});
  EXPECT_EQ(lists.get<Texts>("arguments"), (Texts{"good", "", "two words\n"}));
  EXPECT_EQ(lists.get<Reals>("numbers"), (Reals{0.5, 1e-320}));
  EXPECT_EQ(lists.get<Integers>("counts"), (Integers{-1, std::int64_t(1) << 62}));
  EXPECT_TRUE(lists.get<Integers>("none").empty());
  EXPECT_THROW(lists.get<Integers>("numbers"), std::runtime_error);
}

TEST(ReaderProcess, EveryEndIsASentence) {
  const std::string damaged = " | a file that is not damaged | ";
  const std::string name = "file.x: the unruly reader ";
  EXPECT_EQ(errorOf(unruly, {"crash"}), name + "crashed on it (SIGSEGV)" + damaged);
  EXPECT_EQ(errorOf(unruly, {"abort"}), name + "crashed on it (SIGABRT): a double fault" + damaged);
  EXPECT_EQ(errorOf(unruly, {"killed"}),
            name + "was killed (SIGKILL): by a user, or by the system for lack of memory" + damaged);
  EXPECT_EQ(errorOf(unruly, {"exit"}), name + "ended with code 7" + damaged);
  EXPECT_EQ(errorOf(unruly, {"silence"}), name + "returned no valid data (these are no lists)" + damaged);
  EXPECT_EQ(errorOf(unruly, {"time"}), name + "took more computing time than a file of this size needs" + damaged);
  EXPECT_EQ(errorOf(unruly, {"refuses"}), "folder/file.x is no good | a better one | that one");
  const std::string none = errorOf({"no_such_reader", "the missing reader", "build it"}, {});
  EXPECT_EQ(none.find("the missing reader is not here: build it"), 0u) << none;
}

TEST(ReaderProcess, MemoryIsLimitedByTheSizeOfTheFile) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer takes more than any limit";
#endif
  EXPECT_EQ(errorOf(unruly, {"memory"}),
            "file.x wants more than 256 MB of memory to be read | a file that is not damaged | ");
}

TEST(ReaderProcess, ThreadsMayReadAtOnce) {
  std::vector<std::thread> threads;
  std::array<std::size_t, 4> read{};
  for (std::size_t t = 0; t < read.size(); ++t)
    threads.emplace_back([&read, t] {
      for (int i = 0; i < 5; ++i) read[t] += readInOwnProcess(unruly, "file.x", {"good"}).get<Reals>("numbers").size();
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::size_t numbers : read) EXPECT_EQ(numbers, 10u);
}

TEST(ValueLists, BytesThatAreCutShortOrLongerAreRefused) {
  ValueLists lists;
  lists.add("reals", Reals{1, std::numeric_limits<double>::infinity()});
  lists.add("none", Integers{});
  lists.add("texts", Texts{"a", std::string("\0b", 2)});
  const std::string bytes = lists.bytes();
  EXPECT_EQ(ValueLists::fromBytes(bytes).bytes(), bytes);
  EXPECT_EQ(ValueLists::fromBytes(bytes).get<Texts>("texts")[1].size(), 2u);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(ValueLists::fromBytes(bytes.substr(0, size)), std::runtime_error) << size;
  EXPECT_THROW(ValueLists::fromBytes(bytes + "x"), std::runtime_error);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
