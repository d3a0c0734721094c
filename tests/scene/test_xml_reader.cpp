// SPDX-License-Identifier: LGPL-2.1-or-later
// XML to plain data: positions, round trips, and what a hostile file costs.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "framework/scene/load.h"
#include "tests/scene/test_components.h"
#include "tests/support/xml_writer.h"

namespace stroma {
namespace STROMA_TEST_FILE {

NodeDescription read(const std::string& text, Diagnostics& diagnostics, const ReadLimits& limits = {}) {
  return readXml(text, "folder/scene.xml", limits, diagnostics);
}

/// The one sentence about a file that cannot be read.
Problem refusal(const std::string& text, const ReadLimits& limits = {}) {
  Diagnostics diagnostics;
  read(text, diagnostics, limits);
  EXPECT_EQ(diagnostics.problems().size(), 1u) << diagnostics.text();
  return diagnostics.problems().empty() ? Problem{} : diagnostics.problems()[0];
}

TEST(XmlReader, LinesAndColumnsOfElementsAndAttributes) {
  Diagnostics diagnostics;
  const NodeDescription root = read(
      "<?xml version=\"1.0\"?>\n"
      "<!-- a comment with <Node name='x'> inside -->\n"
      "<Node name=\"root\"\n"
      "      dt=\"0.02\">\n"
      "  <Mesh  a = '1 > 0' b=\"2\"/> <Mass m=\"\xC3\xA9\" n='3'/>\n"
      "  <Node><Object type=\"Force\" k=\"1\n2\" l=\"3\"/></Node>\n"
      "</Node>\n",
      diagnostics);
  ASSERT_FALSE(diagnostics.hasErrors()) << diagnostics.text();
  EXPECT_EQ(root.where.text(), "folder/scene.xml:3:1");
  EXPECT_EQ(root.attributes[1].where.text(), "folder/scene.xml:4:7");
  ASSERT_EQ(root.components.size(), 2u);
  EXPECT_EQ(root.components[0].where.text(), "folder/scene.xml:5:3");
  EXPECT_EQ(root.components[0].attributes[0].where.column, 10);
  EXPECT_EQ(root.components[0].attributes[0].value, "1 > 0");
  EXPECT_EQ(root.components[0].attributes[1].where.column, 22);
  EXPECT_EQ(root.components[1].where.column, 30);
  EXPECT_EQ(root.components[1].attributes[1].where.column, 42) << "a column counts characters, not bytes";
  const ComponentDescription& force = root.children.at(0).components.at(0);
  EXPECT_EQ(force.type, "Force");
  EXPECT_EQ(force.where.text(), "folder/scene.xml:6:9");
  EXPECT_EQ(force.attributes.at(0).name, "k");
  EXPECT_EQ(force.attributes.at(1).where.text(), "folder/scene.xml:7:4");
  EXPECT_EQ(force.folder, "folder");
}

TEST(XmlReader, WhatIsForEditorsIsNothingForTheScene) {
  Diagnostics diagnostics;
  const NodeDescription root = read(
      "<?xml version=\"1.0\"?>\n"
      "<!-- tinyxml2 wants processing instructions before comments -->\n"
      "<?xml-model href=\"stroma.xsd\"\n"
      "  type=\"application/xml\"?><Node xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"\n"
      "   xsi:noNamespaceSchemaLocation=\"stroma.xsd\" name=\"root\"><?editor fold?>\n"
      "  <Mesh a=\"1\"><?inside ?></Mesh>\n"
      "</Node>\n",
      diagnostics);
  EXPECT_TRUE(diagnostics.problems().empty()) << diagnostics.text();
  ASSERT_EQ(root.attributes.size(), 1u);
  EXPECT_EQ(root.attributes[0].name, "name");
  EXPECT_EQ(root.attributes[0].where.text(), "folder/scene.xml:5:47");
  EXPECT_EQ(root.where.text(), "folder/scene.xml:4:27");
  EXPECT_EQ(root.components.at(0).attributes.at(0).where.text(), "folder/scene.xml:6:9");
  // inside a scene it is an attribute like others
  const NodeDescription inner = read("<Node><M xsi:nil=\"1\"/></Node>", diagnostics);
  EXPECT_EQ(inner.components.at(0).attributes.size(), 1u);
  EXPECT_TRUE(refusal("<Node><?never ends </Node>").message.find("processing instruction") != std::string::npos);
}

TEST(XmlReader, EntitiesAndWhiteSpaceOfValues) {
  Diagnostics diagnostics;
  const NodeDescription root = read("<Node name='a'><M x='&lt;1 &amp; 2&#10;3'/></Node>", diagnostics);
  EXPECT_EQ(root.components.at(0).attributes.at(0).value, "<1 & 2\n3");
}

bool sameText(const NodeDescription& a, const NodeDescription& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                      [](const auto& p, const auto& q) { return p.name == q.name && p.value == q.value; });
  };
  return same(a.attributes, b.attributes) &&
         std::equal(
             a.components.begin(), a.components.end(), b.components.begin(), b.components.end(),
             [&](const auto& p, const auto& q) { return p.type == q.type && same(p.attributes, q.attributes); }) &&
         std::equal(a.children.begin(), a.children.end(), b.children.begin(), b.children.end(), sameText);
}

TEST(XmlReader, BytesThatAreZeroAreRefused) {
  for (const std::string before : {"", "<Node>", "<!-- x -->\n", "<Node/>"}) {
    const Problem problem = refusal(before + std::string(1, '\0') + "<Node/>");
    EXPECT_EQ(problem.message, "a byte that is 0 stands in the text");
    EXPECT_EQ(problem.expected, "XML in UTF-8");
    EXPECT_EQ(problem.where.line, before.ends_with("\n") ? 2 : 1);
  }
}

TEST(XmlReader, TypesThatAreNoTagsReadBackToo) {
  Diagnostics diagnostics;
  const NodeDescription root = read(
      "<Node><Object type='Ev]ry' a='1'/><Object type='Node'/><Object type='Object' b='2'/><Object "
      "type='A-b.c2'/></Node>",
      diagnostics);
  ASSERT_EQ(root.components.size(), 4u);
  const std::string text = writeXml(root);
  EXPECT_NE(text.find("<A-b.c2/>"), std::string::npos) << text;
  EXPECT_TRUE(sameText(read(text, diagnostics), root)) << text;
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.text();
}

TEST(XmlReader, WhatIsWrittenReadsBack) {
  Diagnostics diagnostics;
  const NodeDescription root = read(
      "<Node name='r&quot;&amp;' gravity='0 0 -9'><A x='1\n2\t3' y=\"a'b&lt;\"/><include href='f.xml'/>"
      "<Node name='c'><B/><Node/></Node><Node name='d'/></Node>",
      diagnostics);
  const std::string text = writeXml(root);
  const NodeDescription back = read(text, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.text();
  EXPECT_TRUE(sameText(root, back)) << text;
  EXPECT_EQ(writeXml(back), text);
  EXPECT_EQ(root.children.size(), 2u);
  NodeDescription other = back;
  other.children[0].components[0].attributes.push_back({"z", "1", {}});
  EXPECT_FALSE(sameText(root, other)) << "the comparison must be able to fail";
}

TEST(XmlReader, ADocumentTypeThatDefinesNothingIsPassedOver) {
  Diagnostics diagnostics;
  const NodeDescription root = read("<?xml version='1.0'?>\n<!DOCTYPE Node SYSTEM 'scene.dtd'>\n<Node><A x='1'/></Node>", diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.text();
  ASSERT_EQ(root.components.size(), 1u);
  EXPECT_EQ(root.components[0].where.line, 3);
}

TEST(XmlReader, BrokenFilesGetOneSentenceWithLineAndColumn) {
  EXPECT_NE(refusal("<Node>\n  <Mesh a=\"1\"/>\n").text().find(":1:1: error: the file ends before <Node> is closed"),
            std::string::npos);
  EXPECT_EQ(refusal("<Node>\n  <Mesh a=\"1").where.line, 2);
  EXPECT_EQ(refusal("<Node>\n  <Mesh a=\"1").where.column, 9);
  EXPECT_NE(refusal("<Node><A></B></Node>").message.find("does not close <A>"), std::string::npos);
  EXPECT_NE(refusal("<Node><A b/></Node>").message.find("has no value"), std::string::npos);
  EXPECT_NE(refusal("<Node><A b=1/></Node>").message.find("not in quotes"), std::string::npos);
  EXPECT_NE(refusal("<Node><!-- no end </Node>").message.find("ends inside a comment"), std::string::npos);
  EXPECT_NE(refusal("").message.find("no element"), std::string::npos);
  EXPECT_NE(refusal("   \n ").message.find("no element"), std::string::npos);
  EXPECT_NE(refusal("<Node></Node></Node>").message.find("closes nothing"), std::string::npos);
  EXPECT_NE(refusal("<Node/><Node/>").message.find("second root"), std::string::npos);
  EXPECT_EQ(refusal("<node/>").suggestion, "Node");
  EXPECT_NE(refusal("<Node><Object/></Node>").message.find("which component"), std::string::npos);
  EXPECT_NE(refusal("<Node><A b='1' c='' b='2'/></Node>").message.find("'b' is written twice"), std::string::npos);
  EXPECT_EQ(refusal("<Node><A b='1' c='' b='2'/></Node>").where.column, 21);
  EXPECT_NE(refusal("<Node><A><B/></A></Node>").message.find("stands inside <A>"), std::string::npos);
  EXPECT_NE(refusal("<!DOCTYPE x [<!ENTITY a 'b'>]><Node/>").message.find("document type"), std::string::npos);
  EXPECT_NE(refusal("<Node><!DOCTYPE x></Node>").message.find("document type"), std::string::npos);
  EXPECT_NE(refusal(std::string("\0\0\0\0", 4)).message.find("no element"), std::string::npos);
}

TEST(XmlReader, TextBetweenElementsIsNotPassedOver) {
  Diagnostics diagnostics;
  read("<Node>stray <A/></Node>", diagnostics);
  ASSERT_EQ(diagnostics.problems().size(), 1u);
  EXPECT_EQ(diagnostics.problems()[0].severity, Severity::warning);
}

TEST(XmlReader, ATruncatedFileIsRefusedWhereverItEnds) {
  const std::string text = "<Node name='r'><A x='1'/><Node><B y=\"2\"></B><!-- c --></Node></Node>";
  for (std::size_t length = 0; length < text.size(); ++length) refusal(text.substr(0, length));
}

TEST(XmlReader, RandomDamageNeverCrashes) {
  const std::string text =
      "<?xml version='1.0'?><Node name='r'><A x='1 2 3' y=\"&lt;\"/><Node><B y=\"2\"></B><!-- c --></Node></Node>";
  std::mt19937 random(11);
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string damaged = text;
    for (int hits = 1 + int(random() % 4); hits > 0; --hits) {
      const std::size_t at = random() % damaged.size();
      switch (random() % 3) {
        case 0:
          damaged[at] = char(random());
          break;
        case 1:
          damaged.erase(at, 1 + random() % 5);
          break;
        default:
          damaged.insert(at, damaged.substr(random() % damaged.size(), 8));
      }
      if (damaged.empty()) damaged = " ";
    }
    Diagnostics diagnostics;
    read(damaged, diagnostics);
    refused += diagnostics.hasErrors();
  }
  EXPECT_GT(refused, 5000);
}

long peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

TEST(XmlReader, TenThousandDeepIsASentence) {
  std::string text;
  for (int i = 0; i < 10000; ++i) text += "<Node>\n";
  const Problem problem = refusal(text);
  EXPECT_NE(problem.message.find("nested more than 256 deep"), std::string::npos);
  EXPECT_EQ(problem.where.line, 257);
}

TEST(XmlReader, AHugeAttributeIsASentenceThatNamesIt) {
  testing::TemporaryFolder folder;
  const std::string file =
      folder.write("huge.xml", "<Node>\n  <A position=\"" + std::string(100u << 20, '1') + "\"/>\n</Node>");
  const long before = peakMegabytes();
  Diagnostics diagnostics;
  readScene(file, {}, {}, diagnostics);
  ASSERT_EQ(diagnostics.problems().size(), 1u) << diagnostics.text();
  const Problem& problem = diagnostics.problems()[0];
  EXPECT_EQ(problem.where.line, 2);
  EXPECT_EQ(problem.where.column, 6);
  EXPECT_NE(problem.message.find("longer than"), std::string::npos);
  EXPECT_LT(problem.text().size(), 1000u);
  EXPECT_LT(peakMegabytes() - before, 200);
}

TEST(XmlReader, AHugeFileOfSmallPartsIsASentence) {
  ReadLimits limits;
  limits.file_bytes = 10000;
  std::string text = "<Node>";
  while (text.size() < 20000) text += "<A/>";
  EXPECT_NE(refusal(text + "</Node>", limits).message.find("larger than"), std::string::npos);
}

TEST(XmlReader, ManyAttributesOnOneLineTakeLinearTime) {
  std::string text = "<Node>";
  for (int i = 0; i < 200000; ++i) text += "<A b='1' c='2'/>";
  Diagnostics diagnostics;
  const NodeDescription root = read(text + "</Node>", diagnostics);
  EXPECT_EQ(root.components.size(), 200000u);
  EXPECT_EQ(root.components.back().where.column, 7 + 16 * 199999);
}

TEST(XmlReader, WhatIsNotUtf8IsRefusedAtItsPlace) {
  const auto told = [](const std::string& text) { return refusal(text).text(); };
  // "Muskel é" in Latin-1, which the declaration says
  const std::string latin =
      "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<Node name=\"root\">\n  <A name=\"\xE9\"/></Node>";
  EXPECT_NE(told(latin).find(":3:12: error: the byte E9 is not part of a UTF-8 text (expected UTF-8"),
            std::string::npos)
      << told(latin);
  for (const char* wrong : {"\x80", "\xC3", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"})
    EXPECT_NE(told(std::string("<Node name=\"") + wrong + "\"/>").find("UTF-8"), std::string::npos) << wrong;
  for (const char* right :
       {"\xC3\xA9", "\xE2\x82\xAC", "\xED\x9F\xBF", "\xEF\xBB\xBF", "\xF0\x9F\x98\x80", "\xF4\x8F\xBF\xBF"}) {
    Diagnostics diagnostics;
    const NodeDescription root = read(std::string("<Node name=\"") + right + "\"/>", diagnostics);
    EXPECT_EQ(diagnostics.text(), "");
    EXPECT_EQ(root.name(), right);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma
