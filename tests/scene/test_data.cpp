// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/data.h"

#include <gtest/gtest.h>

#include <bit>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <random>

#include "framework/scene/component.h"
#include "tests/support/folder_fixture.h"

namespace stroma {
namespace STROMA_TEST_FILE {

/// Zero; vectors of Eigen have any numbers at first.
template <class T>
T zero() {
  T value{};
  if constexpr (requires { value.setZero(); }) value.setZero();
  return value;
}

template <class T>
T parsed(const std::string& text) {
  T value = zero<T>();
  Data data("value", &value);
  const auto problem = data.parse(text, DataOrigin::written);
  EXPECT_FALSE(problem) << text << ": " << problem->text();
  EXPECT_TRUE(data.isSet());
  return value;
}

template <class T>
Problem refused(const std::string& text, T before = zero<T>()) {
  T value = before;
  Data data("value", &value);
  const auto problem = data.parse(text, DataOrigin::written);
  EXPECT_TRUE(problem) << "accepted: " << text;
  EXPECT_EQ(value, before) << "a refused value must change nothing";
  EXPECT_FALSE(data.isSet());
  return problem.value_or(Problem{});
}

TEST(DataParse, Scalars) {
  EXPECT_EQ(parsed<bool>(" true "), true);
  EXPECT_EQ(parsed<bool>("0"), false);
  EXPECT_EQ(parsed<int>("-12"), -12);
  EXPECT_EQ(parsed<int>("+7"), 7);
  EXPECT_EQ(parsed<double>(" 1e-3\n"), 1e-3);
  EXPECT_EQ(parsed<double>("+.5"), 0.5);
  EXPECT_EQ(parsed<std::string>("two words"), "two words");
  EXPECT_EQ(parsed<Vec3>("1, 2,3"), Vec3(1, 2, 3));
  EXPECT_EQ((parsed<std::array<int, 3>>("4 5\t6")), (std::array<int, 3>{4, 5, 6}));
}

TEST(DataParse, Lists) {
  EXPECT_EQ(parsed<std::vector<double>>("1 2,3\n 4"), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(parsed<std::vector<bool>>("1 false true"), (std::vector<bool>{true, false, true}));
  EXPECT_EQ(parsed<std::vector<std::string>>("a b,c"), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(parsed<std::vector<Vec3>>("1 2 3  4 5 6").size(), 2u);
  EXPECT_EQ(parsed<std::vector<Triangle>>("0 1 2, 2 1 3")[1], (Triangle{2, 1, 3}));
  EXPECT_TRUE(parsed<std::vector<int>>("  ").empty());
}

TEST(DataParse, RangesOfIndices) {
  EXPECT_EQ(parsed<std::vector<int>>("9 3-6 10-20-5"), (std::vector<int>{9, 3, 4, 5, 6, 10, 15, 20}));
  EXPECT_EQ(parsed<std::vector<int>>("-3"), std::vector<int>{-3});
  refused<std::vector<int>>("6-3");
  refused<std::vector<int>>("1-5-0");
  refused<std::vector<int>>("1-5-1-1");
  refused<std::vector<int>>("3-");
}

TEST(DataParse, JunkIsRefusedAndChangesNothing) {
  EXPECT_NE(refused<int>("3.0", 5).message.find("not an integer"), std::string::npos);
  EXPECT_NE(refused<int>("99999999999").message.find("32-bit"), std::string::npos);
  refused<int>("");
  refused<int>("1 2");
  refused<double>("1.0x");
  refused<double>("1,5");
  refused<double>("nan");
  refused<double>("inf");
  refused<double>("1e999");
  refused<double>("0x10");
  refused<double>("+-1");
  refused<bool>("yes");
  refused<Vec3>("1 2", Vec3(7, 8, 9));
  EXPECT_NE(refused<Vec3>("1 2 3 4").message.find("4 numbers instead of 3"), std::string::npos);
  EXPECT_NE(refused<std::vector<Vec3>>("1 2 3 4").message.find("multiple of 3"), std::string::npos);
  EXPECT_NE(refused<std::vector<Vec3>>("1 2 3 0 0 0 1").suggestion.find("Rigid3"), std::string::npos);
  EXPECT_EQ(refused<std::vector<Vec3>>("1 2 3 4").suggestion.find("Rigid3"), std::string::npos);
  EXPECT_NE(refused<std::vector<double>>("1 2 three").message.find("item 3"), std::string::npos);
  EXPECT_NE(refused<std::vector<Triangle>>("0 1 -2").message.find("count from 0"), std::string::npos);
  EXPECT_NE(refused<std::vector<int>>("0-2000000000").message.find("too long"), std::string::npos);
}

TEST(DataParse, AWordOfAnEnumerationAndItsNearest) {
  enum class Method { small, large, polar } method = Method::large;
  DataTable table;
  Data& data = table.addChoice("method", method, {"small", "large", "polar"});
  EXPECT_EQ(data.defaultText(), "large");
  EXPECT_FALSE(data.parse("polar", DataOrigin::written));
  EXPECT_EQ(method, Method::polar);
  const auto problem = data.parse("lrage", DataOrigin::written);
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->suggestion, "large");
  EXPECT_EQ(problem->expected, "one of: small, large, polar");
  EXPECT_EQ(method, Method::polar);
}

TEST(DataParse, Ranges) {
  std::vector<double> ratio{0.45};
  DataTable table;
  Data& data = table.add("poissonRatio", ratio).min(0).max(0.5, false);
  EXPECT_EQ(data.rangeText(), "[0, 0.5)");
  EXPECT_FALSE(data.parse("0", DataOrigin::written));
  const auto problem = data.parse("0.1 0.5", DataOrigin::written);
  ASSERT_TRUE(problem);
  EXPECT_NE(problem->message.find("0.5 (number 2 of the value: commas separate them)"), std::string::npos) << problem->message;
  EXPECT_NE(problem->expected.find("[0, 0.5)"), std::string::npos);
  EXPECT_EQ(ratio, std::vector<double>{0}) << "the value before stays";
}

/// Squares of forces that are made of them must be numbers: of denormals nothing is left but zeros that count as converged.
TEST(DataParse, PhysicalNumbersLeaveRoomForTheirSquares) {
  std::vector<double> value{7};
  Data data("youngModulus", &value);
  data.unit("Pa").physical();
  EXPECT_FALSE(data.parse("0", DataOrigin::written));
  for (const char* taken : {"1e-99", "1e99", "-3", "0"}) EXPECT_FALSE(data.parse(taken, DataOrigin::written)) << taken;
  for (const char* extreme : {"1e-320", "1e-101", "3 1e101"}) {
    const auto problem = data.parse(extreme, DataOrigin::written);
    ASSERT_TRUE(problem) << extreme;
    EXPECT_NE(problem->expected.find("a value of size 1e-100 to 1e100 Pa"), std::string::npos) << problem->text();
  }
  EXPECT_EQ(value, std::vector<double>{0});
  double number = 0;
  Data other("factor", &number);
  EXPECT_FALSE(other.parse("1e-320", DataOrigin::written)) << "any other number may be of any size";
}

TEST(DataPrint, RealsReadBackToTheSameBits) {
  std::mt19937_64 random(7);
  int checked = 0;
  for (int i = 0; i < 200000; ++i) {
    double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    if (!std::isnormal(value) && value != 0) continue;
    double back = 0;
    const std::string text = Data("x", &value).print();
    ASSERT_FALSE(Data("x", &back).parse(text, DataOrigin::written)) << text;
    ASSERT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(back)) << text;
    ++checked;
  }
  EXPECT_GT(checked, 150000);
  double tenth = 0.1, zero = -0.0;
  EXPECT_EQ(Data("x", &tenth).print(), "0.1");
  EXPECT_EQ(Data("x", &zero).print(), "-0");
}

TEST(DataPrint, SubnormalsReadBack) {
  for (double value : {5e-324, 2.2250738585072009e-308}) {
    double back = 0;
    EXPECT_FALSE(Data("x", &back).parse(Data("x", &value).print(), DataOrigin::written));
    EXPECT_EQ(value, back);
  }
}

template <class T>
void roundTrip(T value) {
  T back{};
  const std::string text = Data("x", &value).print();
  EXPECT_FALSE(Data("x", &back).parse(text, DataOrigin::written)) << text;
  EXPECT_EQ(value, back) << text;
}

TEST(DataPrint, EveryTypeReadsBack) {
  roundTrip(true);
  roundTrip(-3);
  roundTrip(std::string("some text"));
  roundTrip(Vec3(1.5, -2, 1e-9));
  roundTrip(std::array<int, 3>{1, 2, 3});
  roundTrip(std::array<double, 16>{1, 0, 0, 0.5});
  roundTrip(std::vector<bool>{true, false});
  roundTrip(std::vector<int>{0, 5, -1});
  roundTrip(std::vector<double>{0.1, 1e300});
  roundTrip(std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
  roundTrip(std::vector<std::string>{"a", "b"});
  roundTrip(std::vector<Edge>{{0, 1}});
  roundTrip(std::vector<Triangle>{{0, 1, 2}});
  roundTrip(std::vector<Quad>{{0, 1, 2, 3}, {4, 5, 6, 7}});
  roundTrip(std::vector<std::array<Index, 5>>{{0, 1, 2, 3, 4}});
  roundTrip(std::vector<std::array<Index, 6>>{{0, 1, 2, 3, 4, 5}});
  roundTrip(std::vector<Hexahedron>{{0, 1, 2, 3, 4, 5, 6, 7}});
}

class DataInALocale : public test::FolderTest {};

TEST_F(DataInALocale, OfTheProcessIsReadAndPrintedAlike) {
  // one with a decimal comma, made here: which ones the system has is its own affair
  const std::string made = "localedef -i de_DE -f UTF-8 " + folder_.string() + "/comma >/dev/null 2>&1";
  if (std::system(made.c_str()) != 0) GTEST_SKIP() << "no locale can be made (package locales)";
  ::setenv("LOCPATH", folder_.c_str(), 1);
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* comma = std::setlocale(LC_ALL, "comma");
  ::unsetenv("LOCPATH");
  ASSERT_TRUE(comma);
  ASSERT_STREQ(std::localeconv()->decimal_point, ",");
  double half = 0.5;
  EXPECT_EQ(Data("x", &half).print(), "0.5");
  EXPECT_EQ(parsed<double>("2.5"), 2.5);
  std::setlocale(LC_ALL, before.c_str());
}

template <class To, class From>
std::optional<Problem> copy(To& to, From from) {
  return Data("to", &to).copyFrom(Data("from", &from));
}

TEST(DataCopy, ConvertsWhatMeansTheSame) {
  std::vector<double> reals;
  std::vector<Vec3> points;
  std::vector<int> integers;
  double real = 0;
  Vec3 point = Vec3::Zero();
  EXPECT_FALSE(copy(points, std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(points, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_FALSE(copy(reals, points));
  EXPECT_EQ(reals, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_FALSE(copy(reals, 7.0));
  EXPECT_EQ(reals, std::vector<double>{7});
  EXPECT_FALSE(copy(real, reals));
  EXPECT_EQ(real, 7);
  EXPECT_FALSE(copy(real, 3));
  EXPECT_EQ(real, 3);
  EXPECT_FALSE(copy(point, std::vector<double>{1, 2, 3}));
  EXPECT_EQ(point, Vec3(1, 2, 3));
  EXPECT_FALSE(copy(points, Vec3(9, 9, 9)));
  EXPECT_EQ(points.size(), 1u);
  EXPECT_FALSE(copy(integers, std::vector<Edge>{{1, 2}, {3, 4}}));
  EXPECT_EQ(integers, (std::vector<int>{1, 2, 3, 4}));
}

TEST(DataCopy, RefusesWhatDoesNot) {
  std::vector<Vec3> points{{1, 1, 1}};
  int integer = 4;
  std::vector<Triangle> triangles;
  EXPECT_TRUE(copy(points, std::vector<double>{1, 2}));
  EXPECT_TRUE(copy(points, std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_TRUE(copy(points, std::string("1 2 3")));
  EXPECT_TRUE(copy(integer, 2.5));
  EXPECT_TRUE(copy(triangles, std::vector<Quad>{{0, 1, 2, 3}}));
  EXPECT_EQ(points.size(), 1u);
  EXPECT_EQ(integer, 4);
  const auto problem = copy(integer, 2.5);
  EXPECT_EQ(problem->expected, "integer");
}

TEST(DataCopy, KeepsTheRange) {
  double ratio = 0.3, bad = 0.7;
  DataTable table;
  Data& data = table.add("ratio", ratio).max(0.5);
  EXPECT_TRUE(data.copyFrom(Data("x", &bad)));
  EXPECT_EQ(ratio, 0.3);
}

TEST(DataTable, NamesAliasesAndDuplicates) {
  double a = 1;
  DataTable table;
  table.add("youngModulus", a).alias("young");
  EXPECT_EQ(table.find("young"), table.find("youngModulus"));
  EXPECT_EQ(table.find("Young"), nullptr);
  EXPECT_EQ(table.names(), (std::vector<std::string>{"youngModulus", "young"}));
  EXPECT_THROW(table.add("young", a), std::logic_error);
}

TEST(DataTable, OutputsCannotBeWritten) {
  std::vector<int> indices;
  DataTable table;
  EXPECT_TRUE(table.add("indices", indices).output().parse("1 2", DataOrigin::written));
  EXPECT_TRUE(indices.empty());
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
