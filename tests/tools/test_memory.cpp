// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene that asks for more memory than a process may have, and the heap that a run begins with.
#include <malloc.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class MemoryOfTheCommand : public CommandTest {};

TEST_F(MemoryOfTheCommand, AMeshThatIsTooLargeIsRefusedAsOtherBadInput) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer takes more address space than a limit leaves";
#endif
  write("large.xml",
        "<Node name='root'>\n  <EulerExplicitSolver/>\n  <RegularGridTopology name='grid' n='500 500 500'/>\n"
        "  <MechanicalObject/>\n  <UniformMass totalMass='1'/>\n</Node>\n");
  const Finished run = shell("(ulimit -v 2000000; '" STROMA_COMMAND "' run large.xml -n 1 --threads 1)");
  EXPECT_EQ(run.code, 2) << run.err;
  EXPECT_NE(run.err.find("large.xml:3"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("/grid"), std::string::npos) << run.err;
  const std::size_t said = run.err.find("it needs more than ");
  ASSERT_NE(said, std::string::npos) << run.err;
  double megabytes = 0;
  ASSERT_EQ(std::sscanf(run.err.c_str() + said, "it needs more than %lf MB of memory", &megabytes), 1) << run.err;
  EXPECT_GT(megabytes, 100) << "125 million nodes take 3000";
  EXPECT_LT(megabytes, 2000000 * 1024. / 1048576);
  EXPECT_NE(run.err.find("nothing was run"), std::string::npos) << run.err;
}

/// The heap of a run has its addresses from the start, advised for huge pages where the kernel knows these, and takes no memory
/// for them. Whether there are huge pages to give is another matter.
TEST_F(MemoryOfTheCommand, TheHeapIsReservedForHugePages) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer has an allocator of its own";
#endif
#ifndef M_TOP_PAD
  GTEST_SKIP() << "this C library's allocator is not told";
#endif
  if (std::getenv("LD_PRELOAD")) GTEST_SKIP() << "another allocator may have come first";
  int overcommit = 0;
  if (std::ifstream strict("/proc/sys/vm/overcommit_memory"); strict >> overcommit && overcommit == 2)
    GTEST_SKIP() << "addresses count as memory here";
  write("point.xml",
        "<Node name='root' dt='0.01'>\n  <EulerExplicitSolver/>\n  <MechanicalObject position='0 0 0'/>\n"
        "  <UniformMass totalMass='1'/>\n</Node>\n");
  write("look.sh",
        "'" STROMA_COMMAND "' run point.xml -n 50000000 --no-record --quiet & run=$!\n"
        "for k in $(seq 300); do\n"
        "  awk '/^[0-9a-f]+-/ {heap = /\\[heap\\]/} heap && /^Size:/ {size += $2} heap && /^Rss:/ {rss += $2}\n"
        "       heap && /^VmFlags:.* hg/ {advised = 1} END {print size + 0, rss + 0, advised + 0}' /proc/$run/smaps > found\n"
        "  read size rest < found; if [ \"$size\" -gt 200000 ]; then sleep 0.2; break; fi; sleep 0.1\n"
        "done\n"
        "kill $run; wait $run; cat found\n");
  const Finished look = shell("sh look.sh");
  long size = 0, rss = 0;
  int advised = 0;
  ASSERT_EQ(std::sscanf(look.out.c_str(), "%ld %ld %d", &size, &rss, &advised), 3) << look.out << look.err;
  EXPECT_GT(size, 250000) << "kB of addresses";
  EXPECT_LT(rss, 32000) << "kB of memory";
  std::ifstream known("/sys/kernel/mm/transparent_hugepage/enabled");
  if (known) EXPECT_EQ(advised, 1) << look.out;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
