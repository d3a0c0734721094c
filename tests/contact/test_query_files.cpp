// SPDX-License-Identifier: LGPL-2.1-or-later
// The program for published sets of queries, on files whose truth is known in exact arithmetic.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/contact/exact_pairs.h"
#include "tests/contact/queries/query_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace exact_pairs;

class QueryFiles : public CommandTest {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const auto path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path.string();
  }
};

std::string linesOf(const FourPoints& start, const FourPoints& end, const std::string& truth) {
  std::string text;
  for (const FourPoints* points : {&start, &end})
    for (const Vec3& p : *points) {
      for (int k = 0; k < 3; ++k) {
        const Rational r(p[k]);
        text += fmt::format("{},{}{}", numerator(r).str(), denominator(r).str(), k < 2 ? "," : "");
      }
      text += truth.empty() ? "\n" : "," + truth + "\n";
    }
  return text;
}

/// One plane separates both sides where they start and where they end, and so on all the way: they do not meet, exactly.
bool areApart(PairKind kind, const FourPoints& start, const FourPoints& end, const Vec3& normal) {
  const std::size_t first_side = kind == PairKind::edge_edge ? 2 : 1;
  const Exact n = exact(normal);
  Rational low, high;
  for (std::size_t i = 0; i < 4; ++i)
    for (const FourPoints* points : {&start, &end}) {
      const Rational height = dot(n, exact((*points)[i]));
      const bool begins = points == &start && (i == 0 || i == first_side);
      if (i < first_side)
        low = begins ? height : std::min(low, height);
      else
        high = begins ? height : std::max(high, height);
    }
  return low > high;
}

/// A file of `count` queries that meet and as many that do not, of all degenerate kinds; the number of both.
std::string querySet(PairKind kind, int count, bool with_truth, std::vector<bool>& truth) {
  Numbers numbers(kind == PairKind::edge_edge ? 21 : 22);
  std::string text;
  for (int i = 0; i < count; ++i) {
    FourPoints x, dx, end;
    double when = 0;
    makeMeeting(numbers, kind, unsigned(i) % 64, when, x, dx);
    for (std::size_t k = 0; k < 4; ++k) end[k] = x[k] + dx[k];
    text += linesOf(x, end, with_truth ? "1" : ""), truth.push_back(true);
    const Vec3 normal(numbers.whole(-3, 3), numbers.whole(-3, 3), numbers.whole(1, 3));
    for (int shift = 0; shift < 64 && !areApart(kind, x, end, normal); ++shift)
      for (std::size_t k = 0; k < (kind == PairKind::edge_edge ? 2u : 1u); ++k) x[k] += 0.25 * normal, end[k] += 0.25 * normal;
    if (!areApart(kind, x, end, normal)) continue;
    text += linesOf(x, end, with_truth ? "0" : ""), truth.push_back(false);
  }
  return text;
}

TEST_F(QueryFiles, NothingThatMeetsIsMissed) {
  for (const auto& [kind, name] :
       {std::pair(PairKind::point_triangle, "vertex-face"), std::pair(PairKind::edge_edge, "edge-edge")}) {
    std::vector<bool> truth;
    const std::string file = write(fmt::format("made/{}/data_0_0.csv", name), querySet(kind, 640, true, truth));
    EXPECT_EQ(kindOfQueries(file), kind);
    const std::vector<Query> queries = readQueries(file);
    ASSERT_EQ(queries.size(), truth.size());
    long meeting = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(queries[i].meets, truth[i]) << i;
      EXPECT_FALSE(queries[i].is_rounded);
      meeting += truth[i];
    }
    EXPECT_GT(long(truth.size()) - meeting, 500);
    for (const double left : {0.1, 1e-6}) {
      const QueryCounts counts = answer(kind, queries, {.left = left, .exact = 300});
      EXPECT_EQ(counts.meeting, meeting);
      EXPECT_EQ(counts.missed, 0);
      EXPECT_EQ(counts.checked, 300);
      EXPECT_EQ(counts.touching, 0);
      EXPECT_EQ(counts.wrong_certificates, 0);
      EXPECT_LT(counts.distance_error, 1e-12);
      EXPECT_LT(counts.cut, left == 0.1 ? counts.queries / 4 : counts.queries / 50);
    }
  }
  const Finished all = shell("'" STROMA_QUERIES "' --exact 10 made");
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_NE(all.out.find("all 2 files: "), std::string::npos) << all.out;
  EXPECT_NE(all.out.find(": 0 missed"), std::string::npos) << all.out;
}

/// Lines of six numbers, and the truth as a list beside them.
TEST_F(QueryFiles, TheTruthMayStandInAFileOfItsOwn) {
  std::vector<bool> truth;
  const std::string text = querySet(PairKind::edge_edge, 5, false, truth);
  std::string list = "[";
  for (const bool meets : truth) list += fmt::format("{}{}", list.size() > 1 ? "," : "", meets);
  const std::string file = write("scene/queries/12ee.csv", text);
  EXPECT_NE(shell("'" STROMA_QUERIES "' " + file).err.find("lines without truth"), std::string::npos);
  write("scene/mma_bool/12ee_mma_bool.json", list + "]");
  EXPECT_EQ(shell("'" STROMA_QUERIES "' " + file).code, 0);
  const std::vector<Query> queries = readQueries(file);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(queries[i].meets, truth[i]) << i;
}

/// A vertex above a triangle, of which a file says that they meet: the program says that this is missed, and its exit code tells.
TEST_F(QueryFiles, WhatIsMissedIsTold) {
  const FourPoints x{Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const std::string file = write("vertex-face/wrong.csv", linesOf(x, x, "1") + linesOf(x, x, "0"));
  const Finished run = shell("'" STROMA_QUERIES "' " + file);
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(run.out.find("2 queries, 1 meet: 1 missed. 0 of 1 that are free are cut short"), std::string::npos) << run.out;
}

TEST_F(QueryFiles, BadFilesAreRefusedWithTheirLine) {
  const FourPoints x{Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const std::string good = linesOf(x, x, "0");
  const auto problemOf = [&](const std::string& text) {
    const Finished run = shell("'" STROMA_QUERIES "' " + write("vertex-face/bad.csv", text));
    EXPECT_EQ(run.code, 2);
    return run.err;
  };
  EXPECT_NE(problemOf(good + "1,2,3\n").find("bad.csv:9: 3 numbers"), std::string::npos);
  EXPECT_NE(problemOf("1,0,0,1,0,1,0\n").find("bad.csv:1: a coordinate is no rational number"), std::string::npos);
  EXPECT_NE(problemOf("a,1,0,1,0,1,0\n").find("bad.csv:1: a coordinate is no rational number"), std::string::npos);
  EXPECT_NE(problemOf("0,1,0,1,0,1,2\n").find("bad.csv:1: the truth is 2"), std::string::npos);
  EXPECT_NE(problemOf("0,1,0,1,0,1,0\n0,1,0,1,0,1,1\n").find("bad.csv:2: the truth is another one"), std::string::npos);
  EXPECT_NE(problemOf("0,1,0,1,0,1,0\n").find("ends within a query"), std::string::npos);
  EXPECT_NE(shell("'" STROMA_QUERIES "' nowhere/edge-edge/a.csv").err.find("no such file"), std::string::npos);
  EXPECT_NE(shell("'" STROMA_QUERIES "' " + write("some.csv", good)).err.find("of which kind"), std::string::npos);
  EXPECT_EQ(shell("'" STROMA_QUERIES "' --help").code, 0);
}

/// A third is no double: such coordinates are rounded, and counted.
TEST_F(QueryFiles, RationalsThatAreNoDoublesAreRounded) {
  std::string text;
  for (int line = 0; line < 8; ++line) text += line == 0 ? "1,3,0,1,-90071992547409920000000000000000001,1,0\n" : "0,1,0,1,0,1,0\n";
  const std::vector<Query> queries = readQueries(write("vertex-face/third.csv", text));
  ASSERT_EQ(queries.size(), 1u);
  EXPECT_TRUE(queries[0].is_rounded);
  EXPECT_EQ(queries[0].start[0].x(), 1. / 3);
  EXPECT_EQ(queries[0].start[0].z(), -9007199254740992e19);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
